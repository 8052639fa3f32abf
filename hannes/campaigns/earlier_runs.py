"""What runs of a campaign do to a machine that later ones find: the motor's charge, and time."""

from collections.abc import Mapping, Sequence

import numpy as np

from hannes.core.parameter import EARLIER
from hannes.core.recording.recording import Recording


def done(recording: Recording) -> dict[str, float]:
    """What one run does, by name; no charge where its current is not recorded."""
    current = np.abs(recording["current"]) if "current" in recording else np.zeros(len(recording))
    return {
        "charge": float(np.trapezoid(current, recording.time)),
        "time": float(np.ptp(recording.time)),
    }


def before_each(recordings: Sequence[Recording]) -> list[Mapping[str, float]]:
    """What the recordings before each of some of one machine did together, in their order."""
    made = np.array([[each[name] for name in EARLIER] for each in map(done, recordings)])
    sums = np.cumsum(made.reshape(-1, len(EARLIER)), axis=0) - made.reshape(-1, len(EARLIER))
    return [dict(zip(EARLIER, row, strict=True)) for row in sums.tolist()]
