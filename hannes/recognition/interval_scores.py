"""Errors of estimates and coverage of their intervals, over all grasps of an evaluation.

A grasp without an estimate counts: its error is larger than any other, and no interval covers it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hannes.recognition.model import Estimate


def judged(pairs: Sequence[tuple[float, Estimate | None]]) -> dict[str, Any]:
    """Counts, median error and bias [%], errors [%], share of intervals that hold, their width.

    pairs: the true value and its estimate. An error is None without an estimate; so is the median
    where half of all have none. width: median of upper end over lower.
    """
    answered = [(true, each) for true, each in pairs if each is not None]
    if not answered:
        return {"grasps": len(pairs), "answered": 0}
    off = np.array([each.value / true - 1.0 for true, each in answered])
    every = np.concatenate([np.abs(off), np.full(len(pairs) - len(answered), np.inf)])
    middle = float(np.median(every))
    return {
        "grasps": len(pairs),
        "answered": len(answered),
        "median_error_percent": 100.0 * middle if np.isfinite(middle) else None,
        "bias_percent": float(100.0 * np.median(off)),
        "errors_percent": [
            round(float(100.0 * each), 2) if np.isfinite(each) else None for each in every
        ],
        "interval_holds": sum(each.low <= true <= each.high for true, each in answered)
        / len(pairs),
        "interval_width": float(np.median([each.high / each.low for _, each in answered])),
    }
