"""Whether the probabilities that verdicts print mean what they say."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.harness import Row, must_show

BINS, MOST = 10, 0.10  # bins of probability, expected calibration error at most
LEAST = 0.001  # probability that counts for a log score
# Outcomes that make a verdict right, by what is hidden; with a remainder a part is right too.
RIGHT = {
    "single": ("right", "class"),
    "closures": ("right", "class"),
    "empty": ("silent",),
    "outside": ("unknown",),
    "pair": ("both", "one"),
    "triple": ("all",),
    "fault": ("right", "class"),
    "sound": ("silent",),
    "opened": ("unknown",),
    "sealed": ("unknown",),
    "MuJoCo sound": ("silent",),
    "MuJoCo slack": ("right", "class"),
    "MuJoCo load": ("right", "class"),
}


def right(case: dict[str, Any]) -> bool:
    """Whether what a verdict says is so."""
    return case["outcome"] in RIGHT[case["what"]]


def probabilities(cases: Sequence[dict[str, Any]]) -> list[Row]:
    """Expected calibration error, and the log score beside that of "always the base rate"."""
    some = [each for each in cases if each.get("probability") is not None]
    if not some:
        return []
    said = np.clip([each["probability"] for each in some], LEAST, 1.0 - LEAST)
    so = np.array([right(each) for each in some], float)
    error, own = calibration_error(said, so), log_score(said, so)
    base = log_score(np.full(so.size, np.clip(so.mean(), LEAST, 1.0 - LEAST)), so)
    return [
        must_show("probability of the answer: calibration error", error, MOST, error <= MOST),
        must_show("the same: log score, base rate as bound", own, base, own <= base),
    ]


def calibration_error(said: np.ndarray, so: np.ndarray) -> float:
    """Mean distance of probability and share that is right, over bins; both (n,)."""
    bins = np.minimum((said * BINS).astype(int), BINS - 1)
    sums = [abs(float(np.sum(said[bins == k] - so[bins == k]))) for k in range(BINS)]
    return sum(sums) / said.size


def log_score(said: np.ndarray, so: np.ndarray) -> float:
    """Mean of minus the logarithm of the probability of what is so; both (n,)."""
    return float(-np.mean(np.log(np.where(so > 0.5, said, 1.0 - said))))
