"""What runs inside the FMU of a hand: the firmware's ticks, as far as a co-simulation asks.

It knows pythonfmu only where it runs, so that hannes does not need it.
"""

import copy
from typing import Any

import numpy as np

OUTPUTS = ("position", "current", "duty", "supply", "force", "sensor", "leader_tension")
EARLY = 1e-9  # s that a communication point may be short of a tick by rounding


class HandSlave:
    """A hand under an experiment; mixed with pythonfmu's Fmi2Slave, which calls its methods.

    `own_reference` true: the experiment's command; else the input `reference` [rad at the output
    shaft], held from one communication point to the next. Outputs are of the communication point.
    """

    EXPERIMENT, HAND = "", ""  # TOML texts, of the class that the FMU carries

    register_variable: Any  # Fmi2Slave's

    def __init__(self, **options: Any) -> None:
        from pythonfmu import Boolean, Fmi2Causality, Fmi2Variability, Real

        super().__init__(**options)
        self.description = "A Hannes hand with the firmware's sampled controller"
        self.reference, self.own_reference = 0.0, True
        held = Fmi2Causality.input
        self.register_variable(Real("reference", causality=held, start=0.0))
        self.register_variable(
            Boolean(
                "own_reference",
                causality=Fmi2Causality.parameter,
                variability=Fmi2Variability.fixed,
            )
        )
        for name in OUTPUTS:
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.output))
        self.stepper: Any = None

    def to_xml(self, *options: Any) -> Any:
        """The model description; outputs are also its initial unknowns, as FMI asks."""
        description = super().to_xml(*options)  # type: ignore[misc]
        structure = description.find("ModelStructure")
        unknowns = copy.deepcopy(structure.find("Outputs"))
        unknowns.tag = "InitialUnknowns"
        structure.append(unknowns)
        return description

    def exit_initialization_mode(self) -> None:
        """Start the hand and make the tick at time 0."""
        from hannes.plants.hand.recorded_hand import hand_of
        from hannes.simulation.experiment.reader import parse_experiment
        from hannes.simulation.stepper import start

        self.stepper = start(hand_of(self.HAND), parse_experiment(self.EXPERIMENT))
        self._tick()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Make all ticks up to the next communication point, its own included."""
        end = current_time + step_size
        while self.stepper.time <= end + EARLY:
            self._tick()
        return True

    def _tick(self) -> None:
        outputs = self.stepper.step(None if self.own_reference else self.reference)
        for name in OUTPUTS:
            setattr(self, name, float(np.asarray(outputs[name])))
