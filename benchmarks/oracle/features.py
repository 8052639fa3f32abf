"""A campaign as one vector: what each condition shows on average over its repeats.

Each channel but the reference in bin means; the current also in how much it moves about the
straight line within a bin, where a ripple shows whose phase no two runs share.
"""

import numpy as np

from benchmarks.truth.bench import FORCES
from benchmarks.truth.campaign import Made
from benchmarks.truth.protocol import Condition, Protocol
from hannes.core.recording.recording import Recording

BINS = 40  # of equal width, over a recording


def names(plan: Protocol, condition: Condition) -> list[str]:
    """Features of a condition, of BINS numbers each."""
    columns = [*plan.channels, *(FORCES if condition.sensor else ())]
    channels = [column.rpartition("_")[0] for column in columns]
    return [*(name for name in channels if name != "reference"), "within current"]


def vector(made: Made, plan: Protocol) -> np.ndarray:
    """All conditions in the order of the protocol, features in the order of `names`."""
    parts = []
    for condition in plan.conditions:
        runs = [
            _of(made.recordings[file], names(plan, condition))
            for file, name in made.conditions.items()
            if name == condition.name
        ]
        parts.append(np.mean(runs, axis=0).ravel())
    return np.concatenate(parts)


def _of(recording: Recording, wanted: list[str]) -> np.ndarray:
    return np.array([_feature(recording, name) for name in wanted])


def _feature(recording: Recording, name: str) -> np.ndarray:
    pieces = np.array_split(recording[name.removeprefix("within ")], BINS)
    if not name.startswith("within "):
        return np.array([piece.mean() for piece in pieces])
    return np.array([_about_line(piece) for piece in pieces])


def _about_line(piece: np.ndarray) -> float:
    """RMS about the straight line of least squares."""
    time = np.linspace(-1.0, 1.0, piece.size)
    rest = piece - piece.mean()
    rest = rest - time * (time @ rest) / (time @ time)
    return float(np.sqrt(np.mean(rest**2)))
