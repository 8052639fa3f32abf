"""Force on a held, unknown object at every sample: an extended Kalman filter on the stepper.

Twins of the hand, each a `Stepper`, are moved as the measured shaft moves; what they predict is the
torque of the leader wire on the motor. What the motor gives follows from the measured current,

    k_t i - T_friction - J dw/dt = r_p T_L / N

Three numbers are estimated from the difference: the object's stiffness (its logarithm), the shaft
angle by which it is touched earlier or later than the twins' own object (slack of the wire, another
size or place), and a constant error of the torque. Their derivatives are differences between the
twins. The force is the first twin's, so friction, springs and wires are those of the whole model.
The residual joins what is left of the difference, over 0.3 s, and the constant error, each in its
standard deviations.

Method: Jazwinski (1970), Stochastic Processes and Filtering Theory, chapter 8.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from hannes.bench.events import About, Event, Restarted, Row
from hannes.bench.grip_loop import Force
from hannes.bench.live import channel_places
from hannes.bench.onset import Onset
from hannes.simulation.experiment.experiment import Experiment, Reference, Target
from hannes.simulation.hand.hand import Hand
from hannes.simulation.stepper import Stepper, start

NORMAL_90 = 1.645  # standard deviations to each end of a 90 % band
EFFECTS = ("leader_slack", "gear_load", "floating_object")
STIFFNESS, OFFSET, BIAS = 0, 1, 2
ASIDE = np.array([0.15, 0.04])  # by which twins differ: log stiffness, angle [rad]
HEAVY = 1e-4  # kg m2, of the twins' rotors
SOFTEST, STIFFEST = math.log(200.0), math.log(150e3)


@dataclass(frozen=True)
class ObserverSettings:
    """Standard deviations, with the object of the twins; SI, angles at the output shaft.

    start: of log stiffness (1), of the angle at the touch [rad], of the torque's error [N m];
    walk: by how much each may change in a second; torque [N m] and its share: errors of the
    measured torque, which last for `memory` [s], as those of a scattered hand do; force_share:
    error of the twins' force alone, by scattered hands; warning: residual from which the machine
    has left the model.
    """

    stiffness: float = 6e3
    offset: float = 0.3
    start: tuple[float, float, float] = (1.6, 1.2, 6e-4)
    walk: tuple[float, float, float] = (0.3, 0.3, 3e-4)
    torque: float = 4e-4
    torque_share: float = 0.05
    memory: float = 0.1
    period: float = 2e-3  # s between two steps of the twins
    force_share: float = 0.1
    least: float = 0.5  # N, of the band to each side
    smoothing: float = 4e-3  # s, of the measured speed
    warning: float = 7.0
    warning_memory: float = 0.3  # s
    gear_loss: float = 0.05  # share of its load, middle of what gears lose
    object: Mapping[str, float] = field(
        default_factory=lambda: {
            "object.radius": 0.023,
            "object.x": 0.013,
            "object.y": -0.047,
            "object.damping": 50.0,
            "object.friction": 0.45,
        }
    )


class ForceObserver:
    """Takes a board's events; gives a Force at each sample while a command runs."""

    def __init__(self, hand: Hand | None = None, settings: ObserverSettings | None = None) -> None:
        self.settings = settings or ObserverSettings()
        base = (hand or Hand()).with_effects(*EFFECTS)
        values = {"floating_object.free": 1.0, "gear_load.coefficient": self.settings.gear_loss}
        self._parameters = dict(base.with_values(values).parameters)
        # A heavy rotor goes on as it was put, whatever the twins' own controllers ask for.
        moved = {"motor.inertia": HEAVY, "controller.period": self.settings.period}
        self._hand = base.with_values({**values, **moved})
        self._onset, self._places = Onset(), list[int]()
        self._twin().step(0.0)  # compiled before any command runs
        self._begin()

    def feed(self, event: Event) -> Force | None:
        """Take one event; return the force at a sample. BadInput where a channel is missing."""
        if isinstance(event, About):
            self._places = channel_places(event)
        elif isinstance(event, Row) and self._places:
            current, position, reference = (event.values[k] for k in self._places)
            return self._sample(event.time, current, position, reference)
        elif self._onset.feed(event) is not None or isinstance(event, Restarted):
            self._begin()
        return None

    @property
    def stiffness(self) -> float:
        """Stiffness of the object as the twins have it [N/m]."""
        return math.exp(self._x[STIFFNESS])

    def begin(self) -> None:
        """Forget the object: another may be held. The twins stay where the hand is."""
        given = self.settings
        self._x = np.array([math.log(given.stiffness), given.offset, 0.0])
        self._spread = np.diag(np.square(given.start))

    def _begin(self) -> None:
        self.begin()
        self._twins = [self._twin() for _ in range(3)]
        self._force = Force(0.0, 0.0, 0.0, 0.0)
        self._last: float | None = None
        self._stepped, self._sum, self._count = 0.0, 0.0, 0
        self._angle, self._speed, self._rate = 0.0, 0.0, 0.0
        self._square = 0.0

    def _twin(self) -> Stepper:
        target = Target("cylinder", dict(self.settings.object))
        resting = Reference([[0.0, 1.0], [0.0, 0.0]])
        experiment = Experiment("twin", 60.0, resting, target, controller="sampled")
        return start(self._hand, experiment, rtol=1e-2)

    def _sample(self, time: float, current: float, position: float, reference: float) -> Force:
        if self._last is None:
            self._last, self._stepped, self._angle = time, time, position
        self._follow(position, time - self._last)
        self._last = time
        self._sum, self._count = self._sum + current, self._count + 1
        period = time - self._stepped
        if period < self.settings.period - 1e-6:
            return replace(self._force, time=time)
        torques, forces = self._predicted(reference)
        slopes = np.array([*(torques[1:] - torques[0]) / ASIDE, 1.0])
        measured = self._measured(self._sum / self._count, torques[0])
        self._update(measured, torques[0], slopes, period)
        self._stepped, self._sum, self._count = time, 0.0, 0
        self._force = self._said(time, forces)
        return self._force

    def _follow(self, position: float, period: float) -> None:
        """Smooth the shaft's angle, speed and acceleration: a fading line through the samples."""
        if period <= 0.0:
            return
        share = 1.0 - math.exp(-period / self.settings.smoothing)
        before = self._speed
        ahead = self._angle + self._speed * period
        off = position - ahead
        self._angle = ahead + (1.0 - (1.0 - share) ** 2) * off
        self._speed += share**2 * off / period
        self._rate += share * ((self._speed - before) / period - self._rate)

    def _predicted(self, reference: float) -> tuple[np.ndarray, np.ndarray]:
        """Torque of the leader wire on the motor [N m] and force [N], of each twin."""
        ratio = self._parameters["gear.ratio"]
        arm = self._parameters["gear.pulley_radius"] / ratio
        torques, forces = np.zeros(3), np.zeros(3)
        for k, twin in enumerate(self._twins):
            stiffness = self._x[STIFFNESS] + (ASIDE[0] if k == 1 else 0.0)
            angle = self._angle + self._x[OFFSET] + (ASIDE[1] if k == 2 else 0.0)
            twin.set_value("object_stiffness", math.exp(stiffness))
            twin.set_state("motor_angle", ratio * angle)
            twin.set_state("motor_speed", ratio * self._speed)
            out = twin.step(reference)
            torques[k], forces[k] = arm * out["leader_tension"], out["force"]
        return torques, forces

    def _measured(self, current: float, load: float) -> tuple[float, float]:
        """Torque that the motor gives to the wire [N m], and its standard deviation."""
        values, given = self._parameters, self.settings
        speed = self._speed * values["gear.ratio"]
        moving = math.tanh(speed / values["motor.friction_speed"])
        dry = values["motor.dry_friction"] + values["gear_load.coefficient"] * abs(load)
        torque = values["motor.torque_constant"] * current - dry * moving
        torque -= values["motor.viscous_friction"] * speed
        inertia = values["motor.inertia"] * self._rate * values["gear.ratio"]
        unknown = dry * (1.0 - moving * moving)
        share = given.torque_share * abs(torque)
        error = math.hypot(given.torque, share, unknown, 0.5 * inertia)
        return torque - inertia, error

    def _update(
        self, measured: tuple[float, float], predicted: float, slopes: np.ndarray, period: float
    ) -> None:
        """One step of the filter."""
        given = self.settings
        self._spread += np.diag(np.square(given.walk)) * period
        torque, error = measured
        noise = error * error * max(given.memory / period, 1.0)
        off = torque - predicted - self._x[BIAS]
        reach = self._spread @ slopes
        gain = reach / (slopes @ reach + noise)
        self._x = self._x + gain * off
        self._x[STIFFNESS] = min(max(self._x[STIFFNESS], SOFTEST), STIFFEST)
        self._spread = self._spread - np.outer(gain, reach)
        self._spread = 0.5 * (self._spread + self._spread.T)
        expected = slopes @ self._spread @ slopes + error * error
        share = min(period / given.warning_memory, 1.0)
        self._square += share * (off * off / expected - self._square)

    def _said(self, time: float, forces: np.ndarray) -> Force:
        given = self.settings
        slopes = (forces[1:] - forces[0]) / ASIDE
        square = slopes @ self._spread[:2, :2] @ slopes + (given.force_share * forces[0]) ** 2
        value = float(forces[0])
        reach = NORMAL_90 * math.sqrt(max(square, 0.0)) + given.least
        residual = math.hypot(math.sqrt(self._square), self._x[BIAS] / given.start[BIAS])
        warns = residual > given.warning
        return Force(time, value, max(value - reach, 0.0), value + reach, residual, warns)
