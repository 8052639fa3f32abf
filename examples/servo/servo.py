"""A geared hobby servo under gravity: a plant of one's own whose equations are compiled.

Its values are those of a servo of 2.5 N m on 7.4 V that swings a load of 0.4 N m.
"""

import functools

import breakaway
import command_lag
import derivative_action
import equations as servo_equations
import gear_backlash
import numpy as np
import supply_sag
import wrong_gravity

from hannes import BadInput, CompiledPlant, Equations, Expected, Parameter, Slot

PARAMETERS = (
    Parameter("control.gain", 8.0, "1/rad", (0.1, 1e3), "duty per position error", "its manual"),
    Parameter("control.limit", 1.0, "1", (0.01, 1.0), "largest duty", "its manual"),
    Parameter("supply.voltage", 7.4, "V", (1.0, 50.0), "without load", "a voltmeter"),
    Parameter("motor.resistance", 2.5, "ohm", (0.05, 100.0), "of the winding", "its data sheet"),
    Parameter("motor.torque_constant", 3e-3, "N m/A", (1e-4, 1.0), "of the motor", "data sheet"),
    Parameter("motor.inertia", 1e-7, "kg m2", (1e-9, 1e-3), "rotor and load, at the motor"),
    Parameter("motor.dry_friction", 5e-4, "N m", (0.0, 0.1), "Coulomb, at the motor", "a guess"),
    Parameter("motor.friction_speed", 0.02, "rad/s", (1e-3, 100.0), "at which it has turned"),
    Parameter("motor.viscous_friction", 5e-7, "N m s/rad", (0.0, 1e-3), "at the motor", "a guess"),
    Parameter("gear.ratio", 300.0, "1", (1.0, 1e4), "motor turns per turn of the shaft"),
    Parameter("gravity.torque", 0.4, "N m", (-20.0, 20.0), "of a level load, at the shaft"),
    Parameter("gravity.angle", 0.3, "rad", (-3.2, 3.2), "from hanging, at position 0"),
)

EQUATIONS = Equations.of(
    servo_equations,
    PARAMETERS,
    states=(
        Slot("motor_angle", "rad", "at the motor", tolerance=1e-6),
        Slot("motor_speed", "rad/s", "at the motor", tolerance=1e-4),
    ),
    channels=(  # what effects may add to
        Slot("reference_time", "s", "time at which the command is read"),
        Slot("aside", "rad", "beside the command, where the controller steers to"),
        Slot("shaft_position", "rad", "of the shaft, where its sensor sits"),
        Slot("duty", "1", "of the drive, as it reaches the motor"),
        Slot("resistance", "ohm", "of the winding"),
        Slot("torque_constant", "N m/A", "of the motor"),
        Slot("supply", "V", "at the drive"),
        Slot("load", "N m", "that the gear carries, at the motor"),
        Slot("gear_friction", "N m", "opposing the motor"),
        Slot("motor_torque", "N m", "further torque on the rotor"),
    ),
    outputs=(
        Slot("reference", "rad", "command"),
        Slot("position", "rad", "of the shaft"),
        Slot("duty", "1", "that the controller asks for"),
        Slot("current", "A", "in the winding"),
    ),
    numbers=(  # what their kernels may read besides parameters, states and channels
        Slot("command", "rad", "that is in force"),
        Slot("first_command", "rad", "at which the recording starts"),
        Slot("back_emf", "V", "of the motor"),
        Slot("motor_speed", "rad/s", "of the motor"),
        Slot("drive_torque", "N m", "of the motor, friction not taken off"),
    ),
)


PLAY, FINE = "gear_backlash.gap", 1e-4  # s, of integration where the shaft flies in its play
ROUNDED = np.sqrt(12.0)  # a count over the standard deviation of what rounding to it leaves
TYPICAL = 0.6745 * np.sqrt(6.0)  # of a second difference of white noise, in the median
SURE = 12.0  # twice an F ratio: chance gives that of fifteen samples once in a hundred
FEWEST = 12  # samples in which a motion stands out of noise
EFFECTS = (breakaway, command_lag, derivative_action, gear_backlash, supply_sag, wrong_gravity)


class Servo(CompiledPlant):
    """P control on position, a clipped duty, a DC motor, a gear, friction and gravity."""

    name = "servo"
    channels = {"time": "s", "reference": "rad", "position": "rad", "duty": "1", "current": "A"}
    required = ("reference", "position")  # it starts where it was recorded
    judged = ("position", "duty", "current")
    expected = {
        "reference": Expected(peak=(1e-3, 20.0), mistakes={"deg taken for rad": 57.3}),
        "position": Expected(follows="reference", peak=(1e-3, 20.0), rate=60.0, lag=0.5),
        "current": Expected(peak=(1e-3, 50.0)),
    }
    base = PARAMETERS
    compiled_from = EQUATIONS
    catalogue = {each.EFFECT.name: each.EFFECT for each in EFFECTS}
    ranges = {  # of a motor that gives 9e-3 N m at most: the shipped ranges are the hand's
        "command_delay.time": (0.0, 0.3),
        "stribeck.torque": (0.0, 2e-3),
        "stribeck.speed": (2.0, 300.0),
    }
    free = {
        "control.gain": 1.0,
        "motor.torque_constant": 3e-4,
        "motor.inertia": 3e-8,
        "motor.dry_friction": 2e-4,
        "motor.viscous_friction": 3e-7,
        "gravity.torque": 0.1,
        "gravity.angle": 0.1,
    }
    uncertain = {
        **{each.name: each.value for each in PARAMETERS if each.name not in (
            "control.limit", "motor.friction_speed", "gear.ratio", "gravity.angle")},
        "gravity.angle": 1.0,
    }  # fmt: skip
    run_to_run = {"motor.dry_friction": 0.01 * 5e-4, "motor.viscous_friction": 0.01 * 5e-7}
    start_time = 1e-3  # s
    block = 0.5  # s
    step = 1e-3  # s, of integration at most

    def accepts(self, effect):
        """Return why the servo cannot carry an effect, or an empty string."""
        if effect.name == "torque_ripple":
            return "its waves, 20 mrad of the shaft and less, are finer than what the servo logs"
        return super().accepts(effect)

    def check(self, recording):
        """Raise BadInput unless there is something to compare after the first sample."""
        if len(recording) < 2:
            raise BadInput("a servo's recording of one sample: expected a motion")

    def simulate(self, parameters, recording):
        """From rest where the recording starts, under its command; channels of shape (n,)."""
        values = self.parameters.with_values(parameters)
        reference = np.array([recording.time, recording["reference"]])
        start = (rest(recording) * values["gear.ratio"], 0.0)
        flies = PLAY in values.declared and values[PLAY] > 0.0
        return self.run(parameters, recording.time, reference, start, FINE if flies else self.step)

    def same_run(self, recording):
        """Equal where commands are: starts differ by what the sensor counts."""
        return recording.time.tobytes() + recording["reference"].tobytes()

    def phases(self, recording):
        """While the command moves, and while it rests."""
        moved = np.abs(np.diff(recording["reference"], prepend=recording["reference"][0])) > 1e-9
        near = np.convolve(moved, np.ones(15), "full")[: moved.size] > 0.0  # and shortly after
        return {"moving": near, "resting": ~near}


def rest(recording):
    """Position [rad] where the recording starts, from all before the command first moves.

    The mean, as a sensor is noisy; of a servo that is let go there and sinks until friction holds
    it, where that motion began.
    """
    asked, seen = recording["reference"], recording["position"]
    moved = np.flatnonzero(asked != asked[0])
    return start_of(seen[: max(1, moved[0] if moved.size else seen.size)].tobytes())


@functools.lru_cache(maxsize=256)  # a diagnosis asks for the same ones a thousand times
def start_of(samples):
    """Where positions begin whose bytes these are."""
    still = np.frombuffer(samples)
    if still.size < FEWEST:
        return still.mean()
    left, found = np.sum((still - still.mean()) ** 2), min(sunk(still, n) for n in ends(still, 4))
    if left <= (1.0 + SURE / (still.size - 3)) * found[0]:
        return still.mean()
    noise = noise_of(still)
    return found[1] if found[0] <= most(still.size, noise) else let_go(still, noise)


def ends(still, first):
    """Numbers of samples that a motion may take, at most twenty of them."""
    return np.unique(np.geomspace(first, still.size - 1, 20).astype(int))


def sunk(still, last):
    """Squares left by a smooth step that ends at sample `last`, and where it begins."""
    share = np.minimum(np.arange(still.size) / last, 1.0)
    step = np.column_stack((np.ones(still.size), share**2 * (3.0 - 2.0 * share)))
    values = np.linalg.lstsq(step, still)[0]
    return np.sum((still - step @ values) ** 2), values[0]


def let_go(still, noise):
    """Where a constant acceleration begins that the longest possible time fits."""
    for size in ends(still, 3)[::-1]:
        since = np.column_stack((np.ones(size), np.arange(size) ** 2.0))
        fitted, left, *_ = np.linalg.lstsq(since, still[:size])
        if left.sum() <= most(size, noise):
            return fitted[0]
    return still[0]


def noise_of(still):
    """Standard deviation of a sensor's noise [rad], counts included, by how samples follow."""
    noise = np.median(np.abs(np.diff(still, 2))) / TYPICAL
    steps = np.diff(np.unique(still))
    return max(noise, steps.min() / ROUNDED) if steps.size else noise


def most(size, noise):
    """Squares that noise of `size` samples leaves at most of a fit of two numbers."""
    return (size - 2 + np.sqrt(2.0 * size)) * noise**2
