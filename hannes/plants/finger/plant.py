"""The finger as a plant: the recorded angle drives it, the logged force is compared.

Any recording with channels `angle` and `force`, both the hand's own counts, will do. Its effects
are its own: a hand's wires and motor are not in it.
"""

from collections.abc import Mapping

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter, group
from hannes.core.recording.channel_limits import Expected
from hannes.core.recording.recording import Recording
from hannes.plants.compiled import CompiledPlant
from hannes.plants.finger import (
    creeping_contact,
    equations,
    force_lag,
    force_offset,
    hunt_crossley,
    reading_delay,
)
from hannes.simulation.compiler.assemble import Equations

PARAMETERS = group(
    "contact",
    Parameter("stiffness", 5000.0, "1", (1.0, 1e6), "force counts at 100 counts of depth"),
    Parameter("angle", 7.0, "1", (0.0, 10.0), "at which it touches, 100 counts"),
    Parameter("exponent", 1.5, "1", (0.5, 5.0), "of the depth", "Hertz (1882), a sphere"),
)

# Between two samples the angle at their end holds. Each state responds exponentially, which is
# exact for a linear state that no other state acts on.
_RUN = '''

@entry
def run(times, y, p, reference, memories, states):
    """Fill states (n, states) at `times` [s]; y is the state at times[0]."""
    rate, moved, other = np.zeros(STATES), np.zeros(STATES), np.zeros(STATES)
    c, out = np.zeros(CHANNELS), np.zeros(OUTPUTS)
    for k in range(times.size):
        if k > 0:
            t, h = times[k], times[k] - times[k - 1]
            equations(t, y, rate, p, c, reference, memories[k], out)
            for j in range(STATES):
                moved[:] = y
                moved[j] += 1e-6 * max(abs(y[j]), 1.0)
                equations(t, moved, other, p, c, reference, memories[k], out)
                decay = h * (other[j] - rate[j]) / (moved[j] - y[j])
                share = np.expm1(decay) / decay if abs(decay) > 1e-9 else 1.0
                states[k, j] = y[j] + share * h * rate[j]
            y[:] = states[k]
        states[k] = y
'''

EQUATIONS = Equations.of(
    equations,
    PARAMETERS,
    channels=(
        Slot("reading_time", "s", "time at which the angle is read"),
        Slot("contact_force", "1", "of the object on the finger, counts"),
        Slot("logged_force", "1", "as the hand logs it, counts"),
    ),
    outputs=(
        Slot("angle", "1", "of the actuator, counts"),
        Slot("contact_force", "1", "of the object on the finger, counts"),
        Slot("force", "1", "as the hand logs it, counts"),
    ),
    numbers=(
        Slot("angle", "1", "of the actuator as it is read, counts"),
        Slot("rested", "1", "force at which the recording starts, counts"),
        Slot("closing_speed", "1/s", "of the actuator, counts a second"),
        Slot("elastic", "1", "force of the static contact law, counts"),
        Slot("force", "1", "of the object on the finger, counts"),
        Slot("first_reading", "1", "of the force in the recording, counts"),
    ),
    entries=_RUN,
)

OWN = (
    creeping_contact.EFFECT,
    force_lag.EFFECT,
    force_offset.EFFECT,
    hunt_crossley.EFFECT,
    reading_delay.EFFECT,
)


class Finger(CompiledPlant):
    """Plant: the finger with `effects` in its model; see plants/protocol.py for the protocol."""

    name = "finger"
    channels: Mapping[str, str] = {"time": "s", "angle": "1", "force": "1"}
    base = PARAMETERS
    required: tuple[str, ...] = ("angle", "force")  # the reading starts as recorded
    judged: tuple[str, ...] = ("force",)
    expected: Mapping[str, Expected] = {
        "angle": Expected(peak=(100.0, 2000.0), forward=True),
        "force": Expected(peak=(1.0, 1e4)),
    }
    free: Mapping[str, float] = {
        "contact.stiffness": 5000.0,
        "contact.angle": 0.5,
        "contact.exponent": 0.5,
    }
    robust: Mapping[str, float] = {"force": 100.0}  # a finger may slip, and an object give way
    block = 1.0  # s, over which residuals are taken as independent
    compiled_from = EQUATIONS
    catalogue: Mapping[str, Effect] = {each.name: each for each in OWN}

    def check(self, recording: Recording) -> None:
        """Raise BadInput unless there is something to compare after the first sample."""
        if len(recording) < 2:
            raise BadInput("a finger's recording of one sample: expected a closing, or an opening")

    def simulate(
        self, parameters: Mapping[str, float], recording: Recording
    ) -> dict[str, np.ndarray]:
        """Press as the recorded angle does; channels at the recorded times, shape (n,).

        Raises ComputationFailed where the force is not finite.
        """
        compiled, p = self.compiled, self.packed(parameters)
        times, reference = recording.time, np.array([recording.time, recording["angle"]])
        memories, state = _memories(recording), np.zeros(compiled.states.size)
        states = np.zeros((times.size, state.size))
        compiled.fast.run(times, state, p, reference, memories, states)
        return self.observed(times, states, p, reference, memories)

    def same_run(self, recording: Recording) -> bytes:
        """Return a key, equal for recordings that one simulation serves."""
        start = recording["force"][:1].tobytes()
        return start + recording.time.tobytes() + recording["angle"].tobytes()

    def judged_part(self, recording: Recording) -> np.ndarray:
        """Every sample is compared."""
        return np.ones(len(recording), bool)

    def phases(self, recording: Recording) -> dict[str, np.ndarray]:
        """Masks by the angle: closing, opening, or resting closed or open."""
        angle = recording["angle"]
        speed = np.gradient(angle, recording.time)
        still = np.abs(speed) <= 0.02 * np.abs(speed).max()
        far = angle > 0.5 * (angle.min() + angle.max())
        return {
            "closing": (speed < 0.0) & ~still,
            "opening": (speed > 0.0) & ~still,
            "held": still & ~far,
            "open": still & far,
        }


def _memories(recording: Recording) -> np.ndarray:
    """First angle, first reading, speed of closing [100 counts/s] of each sample, shape (n, 3)."""
    angle, size = recording["angle"], len(recording)
    speed = -0.01 * np.diff(angle) / np.diff(recording.time)
    first = (np.full(size, angle[0]), np.full(size, recording["force"][0]))
    return np.column_stack((*first, np.concatenate(([0.0], speed))))
