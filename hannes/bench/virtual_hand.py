"""The hand's model as a board's machine: one tick of the firmware a step, and sensor noise."""

from dataclasses import replace

import numpy as np

from hannes.bench.messages import Channel
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.stepper import Stepper, start

AMBIENT, WARMING, HEATING = 25.0, 8.0, 30.0  # degC; K a watt in the winding; s until it has them
LIMIT = "position_pid_limit"  # A, of the outer PID's output: at zero the drive gives no current
CHANNELS = (
    Channel(0, "reference", "rad", "i", 1e-6),
    Channel(1, "position", "rad", "i", 1e-6),
    Channel(2, "current", "A", "i", 1e-5),
    Channel(3, "duty", "1", "h", 1e-4),
    Channel(4, "supply", "V", "H", 1e-3),
)


class VirtualHand:
    """Machine: `hand` under `experiment`, of which object, noise and controller count.

    `truth` has what no board measures, at the last tick: force and sensor [N]. `step` gives the
    winding's `temperature` [degC] too, no channel, which the board holds against its limit.
    """

    channels: tuple[Channel, ...] = CHANNELS

    def __init__(self, hand: Hand, experiment: Experiment, rtol: float = 1e-3) -> None:
        sampled = replace(experiment, controller="sampled")
        self._stepper: Stepper = start(hand, sampled, rtol=rtol)
        self._limit = self._stepper.value(LIMIT)
        self._noise = dict(experiment.noise)
        self._chance = np.random.default_rng(experiment.seed)
        self._shaft = float(self._stepper.state()["motor_angle"][0]) / hand.parameters["gear.ratio"]
        self._open = False
        self._resistance = hand.parameters["motor.resistance"]
        self._temperature = AMBIENT
        self.truth = {"force": 0.0, "sensor": 0.0}

    @property
    def rate(self) -> float:
        """Ticks a second [Hz]."""
        return 1.0 / self._stepper.period

    def step(self, reference: float | None) -> dict[str, float]:
        """Go on by one tick; None opens the drive, and the springs open the hand."""
        if (reference is None) != self._open:
            self._open = reference is None
            self._stepper.set_value(LIMIT, 0.0 if self._open else self._limit)
        outputs = self._stepper.step(self._shaft if reference is None else reference)
        self._shaft = float(outputs["position"])
        self.truth = {name: float(outputs[name]) for name in self.truth}
        self._warm(float(outputs["current"]))
        measured = {channel.name: self._noisy(channel.name, outputs) for channel in self.channels}
        return measured | {"temperature": self._temperature}

    def _warm(self, current: float) -> None:
        """Warm the winding for a tick by its current [A]."""
        settled = AMBIENT + WARMING * self._resistance * current**2
        self._temperature += self._stepper.period / HEATING * (settled - self._temperature)

    def _noisy(self, name: str, outputs: dict[str, float]) -> float:
        spread = self._noise.get(name, 0.0)
        return float(outputs[name]) + (spread * self._chance.standard_normal() if spread else 0.0)
