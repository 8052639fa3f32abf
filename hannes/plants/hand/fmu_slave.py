"""What runs inside the FMU of a hand: the firmware's ticks, as far as a co-simulation asks.

It knows pythonfmu only where it runs, so that hannes does not need it.
"""

import copy
from typing import Any

import numpy as np

# Outputs with unit and meaning.
OUTPUTS = {
    "position": ("rad", "angle of the output shaft"),
    "current": ("A", "motor current"),
    "duty": ("1", "duty of the drive"),
    "supply": ("V", "voltage of the supply"),
    "force": ("N", "normal forces on the object, their sum"),
    "sensor": ("N", "force that the object's sensor reads"),
    "leader_tension": ("N", "tension of the leader wire"),
}
# Units by what they are in SI's base units.
UNITS = {
    "rad": {"rad": "1"},
    "A": {"A": "1"},
    "1": {},
    "V": {"kg": "1", "m": "2", "s": "-3", "A": "-1"},
    "N": {"kg": "1", "m": "1", "s": "-2"},
}
EARLY = 1e-9  # s that a communication point may be short of a tick by rounding


class HandSlave:
    """A hand under an experiment; mixed with pythonfmu's Fmi2Slave, which calls its methods.

    `own_reference` true: the experiment's command; else the input `reference` [rad at the output
    shaft], held from one communication point to the next. Outputs are of the communication point.
    """

    EXPERIMENT, HAND = "", ""  # TOML texts, of the class that the FMU carries
    DURATION, PERIOD = 1.0, 1e-3  # s, of the experiment and of the firmware's ticks

    register_variable: Any  # Fmi2Slave's

    def __init__(self, **options: Any) -> None:
        from pythonfmu import Boolean, DefaultExperiment, Fmi2Causality, Fmi2Variability, Real

        super().__init__(**options)
        self.description = "A Hannes hand with the firmware's sampled controller"
        self.reference, self.own_reference = 0.0, True
        held = Fmi2Causality.input
        wanted = "wanted angle of the output shaft, where own_reference is false"
        self.register_variable(Real("reference", causality=held, start=0.0, description=wanted))
        self.register_variable(
            Boolean(
                "own_reference",
                causality=Fmi2Causality.parameter,
                variability=Fmi2Variability.fixed,
                description="whether the experiment's own command moves the hand",
            )
        )
        for name, (_, meaning) in OUTPUTS.items():
            setattr(self, name, 0.0)
            output = Fmi2Causality.output
            self.register_variable(Real(name, causality=output, description=meaning))
        self.default_experiment = DefaultExperiment(0.0, self.DURATION, self.PERIOD)
        self.stepper: Any = None

    def to_xml(self, *options: Any) -> Any:
        """The model description with units; outputs are also initial unknowns, as FMI asks."""
        description = super().to_xml(*options)  # type: ignore[misc]
        _with_units(description)
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


def _with_units(description: Any) -> None:
    """Add units, which pythonfmu leaves out, where FMI has them: after the co-simulation's node."""
    from xml.etree.ElementTree import Element, SubElement

    defined = Element("UnitDefinitions")
    for name, base in UNITS.items():
        SubElement(SubElement(defined, "Unit", name=name), "BaseUnit", base)
    places = [each.tag for each in description]
    description.insert(places.index("CoSimulation") + 1, defined)
    units = {"reference": "rad", **{name: unit for name, (unit, _) in OUTPUTS.items()}}
    for variable in description.find("ModelVariables"):
        if (unit := units.get(variable.get("name"))) is not None:
            variable.find("Real").set("unit", unit)
