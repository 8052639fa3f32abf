"""Period of the command of a recording: a long record is then several runs."""

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality.subject import Subject, true_runs
from hannes.core.recording.recording import Recording
from hannes.plants.protocol import Plant, expectations

FloatArray = NDArray[np.float64]

EVEN = 1e-3  # of an interval, largest scatter of times
SAME = 1e-6  # of its range, largest difference of a command from its repeat
AWAY = 0.1  # of its variance, least change of a command before it returns


def inputs(plant: Plant, recording: Recording) -> list[str]:
    """Channels of a recording that drive the plant: commands, and those it requires.

    Not those that are compared or that follow another.
    """
    expected = dict(expectations(plant))
    commands = Subject(recording, expected).commands | set(plant.required)
    followers = {name for name, each in expected.items() if each.follows}
    found = commands - followers - set(plant.judged)
    return [name for name in recording.names if name in found]


def period(plant: Plant, recording: Recording) -> int:
    """Period, in samples, of all channels that drive the plant; 0 where they never repeat."""
    driving = [recording[name] for name in inputs(plant, recording)]
    moving = [values for values in driving if np.ptp(values) > 0.0]
    intervals = np.diff(recording.time)
    if not moving or np.ptp(intervals) > EVEN * float(np.median(intervals)):
        return 0
    found = (k for k in _returns(moving[0]) if all(_repeats(values, k) for values in moving))
    return next(found, 0)


def _repeats(values: FloatArray, shift: int) -> bool:
    off = np.abs(values[shift:] - values[:-shift]).max()
    return bool(off <= SAME * np.ptp(values))


def _returns(values: FloatArray) -> list[int]:
    """Shifts, up to half the record, of the minima of a signal's distance to itself."""
    from scipy.signal import correlate

    centred, size = values - values.mean(), values.size
    shifts = np.arange(size // 2 + 1)
    squares = np.concatenate(([0.0], np.cumsum(centred**2)))
    ends = squares[size - shifts] + squares[-1] - squares[shifts]
    products = correlate(centred, centred, "full", "fft")[size - 1 :][shifts]
    distance = (ends - 2.0 * products) / (size - shifts) / np.var(centred)
    near = true_runs(distance < AWAY)
    return [first + int(np.argmin(distance[first : last + 1])) for first, last in near[1:]]
