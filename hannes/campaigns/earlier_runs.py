"""What runs of a campaign do to a machine that later ones find: the motor's charge, and time."""

from collections.abc import Mapping, Sequence

import numpy as np

from hannes.core.parameter import EARLIER
from hannes.core.recording.recording import Recording


def done(recording: Recording) -> dict[str, float]:
    """What one run does, by name; without its charge where its current is not recorded.

    The charge is of the current's size: noise of a motor at rest adds to it.
    """
    found = {"time": float(np.ptp(recording.time))}
    if "current" in recording:
        found["charge"] = float(np.trapezoid(np.abs(recording["current"]), recording.time))
    return found


def after(earlier: Mapping[str, float], recording: Recording) -> dict[str, float]:
    """What runs did by the end of this one, by what was done before it; what is known of it."""
    return {name: earlier[name] + own for name, own in done(recording).items() if name in earlier}


def before_each(recordings: Sequence[Recording]) -> list[Mapping[str, float]]:
    """What the recordings before each of some of one machine did together, in their order."""
    made: list[Mapping[str, float]] = []
    so_far: Mapping[str, float] = dict.fromkeys(EARLIER, 0.0)
    for each in recordings:
        made.append(so_far)
        so_far = after(so_far, each)
    return made
