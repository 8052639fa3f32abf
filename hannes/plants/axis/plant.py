"""The second plant: a motor-driven axis in closed loop with its sampled controller (EMPS).

Any recording with channels `reference` [m], `position` [m] and `drive` [V] will do; `pulses` [V]
are added behind the controller's limit.
"""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from hannes.control import cascade
from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter, group
from hannes.core.recording.recording import Recording
from hannes.plants.axis import equations as axis_equations
from hannes.plants.axis import slow_friction
from hannes.plants.axis.channel_limits import EXPECTED
from hannes.plants.compiled import CompiledPlant
from hannes.simulation.compiler.assemble import Equations

PUBLISHED = "Janot, Gautier & Brunot (2019), symmetric model"

PARAMETERS = (
    group(
        "axis",
        Parameter("mass", 95.1089, "kg", (1.0, 1e3), "everything that moves", PUBLISHED),
        Parameter("offset", -3.1648, "N", (-100, 100), "constant force against +", PUBLISHED),
        Parameter("force_gain", 35.150652, "N/V", (0.1, 1e3), "of the drive", "EMPS data set"),
    )
    + group(
        "motor",
        Parameter("dry_friction", 20.3935, "N", (0, 200), "guides and screw", PUBLISHED),
        Parameter("friction_speed", 1e-3, "m/s", (1e-5, 0.1), "width of the dry-friction tanh"),
        Parameter("viscous_friction", 203.5034, "N s/m", (0, 2e3), "guides, screw", PUBLISHED),
    )
    + cascade.PARAMETERS
)

# The whole record in one call: at each sample the controller, then RK4 with the voltage held.
_RUN = '''

@entry
def run(times, y, p, reference, added, memory, substeps, states, memories):
    """Fill states (n, STATES) and memories (n, 4) at `times` [s]; y is the state at times[0]."""
    c, out, scratch = np.zeros(CHANNELS), np.zeros(OUTPUTS), np.zeros(STATES)
    k1, k2, k3, k4 = np.zeros(STATES), scratch.copy(), scratch.copy(), scratch.copy()
    for k in range(times.size):
        t = times[k]
        memory[3] = added[k]
        sample(t, y, scratch, p, c, reference, memory, out)
        states[k] = y
        memories[k] = memory
        if k + 1 == times.size:
            break
        h = (times[k + 1] - t) / substeps
        for part in range(substeps):
            equations(t, y, k1, p, c, reference, memory, out)
            equations(t + 0.5 * h, y + 0.5 * h * k1, k2, p, c, reference, memory, out)
            equations(t + 0.5 * h, y + 0.5 * h * k2, k3, p, c, reference, memory, out)
            equations(t + h, y + h * k3, k4, p, c, reference, memory, out)
            y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            t += h
'''

EQUATIONS = Equations.of(
    axis_equations,
    PARAMETERS,
    states=(
        Slot("axis_position", "m", "of the load", tolerance=1e-8),
        Slot("motor_speed", "m/s", "of the load", tolerance=1e-6),
    ),
    channels=(
        Slot("reference_time", "s", "time at which the reference is read"),
        Slot("measured_position", "m", "what the controller sees"),
        Slot("voltage", "V", "of the drive"),
        Slot("gear_friction", "N", "opposing the axis"),
        Slot("motor_torque", "N", "further force on the axis"),
    ),
    outputs=(
        Slot("reference", "m", "where the axis should be"),
        Slot("position", "m", "encoder"),
        Slot("drive", "V", "controller output, added volts included"),
        Slot("friction", "N", "opposing the axis"),
    ),
    numbers=(
        Slot("force", "N", "of the motor on the axis"),
        Slot("load", "N", "that the screw carries"),
    ),
    entries=_RUN,
)

SUBSTEPS = 2  # per sample; tests/plants/test_axis.py shows that more change nothing
START = 0.02  # s of the record from which the start speed is read
FEWEST = 4  # samples from which the start position and speed are read
SHORTEST = 0.2  # s, of a recording that can be judged


class Axis(CompiledPlant):
    """Plant: the axis with `effects` in its model; see plants/protocol.py for the protocol."""

    name = "axis"
    channels: Mapping[str, str] = {
        "time": "s",
        "reference": "m",
        "position": "m",
        "drive": "V",
        "pulses": "V",
    }
    base = PARAMETERS
    required: tuple[str, ...] = ("reference", "position")
    judged: tuple[str, ...] = ("drive",)
    expected = EXPECTED
    # What a refit fits, with the standard deviation of the nominal value.
    free: Mapping[str, float] = {
        "axis.mass": 10.0,
        "motor.dry_friction": 5.0,
        "motor.viscous_friction": 50.0,
        "axis.offset": 5.0,
    }
    compiled_from = EQUATIONS
    catalogue: Mapping[str, Effect] = {slow_friction.EFFECT.name: slow_friction.EFFECT}
    block = 1.0  # s, over which residuals are taken as independent
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {"warming_grease.fall": (0.0, 0.2)}  # 1/J

    def check(self, recording: Recording) -> None:
        """Raise BadInput unless the recording is long enough to start from."""
        start_state(recording)

    def simulate(
        self, parameters: Mapping[str, float], recording: Recording, substeps: int = SUBSTEPS
    ) -> dict[str, np.ndarray]:
        """Drive the axis by the recorded reference; channels at the recorded times, shape (n,).

        Starts at the recorded position and speed. `substeps`: RK4 steps per sample. Raises
        ComputationFailed where it diverges.
        """
        compiled, p = self.compiled, self.packed(parameters)
        times, reference = recording.time, np.array([recording.time, recording["reference"]])
        added = recording["pulses"] if "pulses" in recording else np.zeros(times.size)
        state = np.zeros(compiled.states.size)
        state[:2] = start_state(recording)
        period = p[compiled.parameters["cascade_period"]][0]
        before = [state[0] - k * period * state[1] for k in (1, 2)]
        memory, states = np.array([0.0, *before, 0.0]), np.zeros((times.size, state.size))
        memories = np.zeros((times.size, 4))
        compiled.fast.run(times, state, p, reference, added, memory, substeps, states, memories)
        return self.observed(times, states, p, reference, memories)

    def same_run(self, recording: Recording) -> bytes:
        """Return a key, equal for recordings that one simulation serves."""
        names = ("time", "reference", "pulses")
        start = start_state(recording).tobytes()
        return start + b"".join(recording[n].tobytes() for n in names if n in recording)

    def judged_part(self, recording: Recording) -> np.ndarray:
        """Mask of the samples that are compared: not the first 0.1 s, not the last 0.05 s."""
        t = recording.time
        return (t >= t[0] + 0.1) & (t <= t[-1] - 0.05)

    def phases(self, recording: Recording) -> dict[str, np.ndarray]:
        """Masks by the reference: forth, back, or standing."""
        speed = np.gradient(recording["reference"], recording.time)
        slow = 0.02 * np.abs(speed).max()
        phases = {"forth": speed > slow, "back": speed < -slow, "standing": np.abs(speed) <= slow}
        if "pulses" in recording:
            pulses = np.abs(recording["pulses"]) > 0.0
            phases = {name: mask & ~pulses for name, mask in phases.items()}
            phases["pulse"] = pulses
        return phases


def start_state(recording: Recording) -> np.ndarray:
    """Position [m] and speed [m/s] at the first sample, from a parabola through the first 20 ms."""
    t = recording.time - recording.time[0]
    first = t <= START
    if np.count_nonzero(first) < FEWEST or t[-1] - t[0] < SHORTEST:
        raise BadInput(
            f"an axis recording of {len(recording)} samples over {t[-1] - t[0]:.3g} s: expected at "
            f"least {SHORTEST:g} s, and {FEWEST} samples in the first {START:g} s to start from"
        )
    slope = np.polyfit(t[first], recording["position"][first], 2)[1]
    return np.array([recording["position"][0], slope])
