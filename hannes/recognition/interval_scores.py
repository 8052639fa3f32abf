"""How far estimates are off, and how often their intervals hold, over all grasps of an evaluation.

A grasp of which nothing is told counts: it is off by more than any other, and no interval holds it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hannes.recognition.model import Estimate


def judged(pairs: Sequence[tuple[float, Estimate | None]]) -> dict[str, Any]:
    """Counts, median error and bias [%], errors [%], share of intervals that hold, their width.

    pairs: the truth, and what was told of it. An error is None where nothing was told, the median
    where that is so of half of all. width: median of upper end over lower.
    """
    told = [(true, each) for true, each in pairs if each is not None]
    if not told:
        return {"grasps": len(pairs), "told": 0}
    off = np.array([each.value / true - 1.0 for true, each in told])
    every = np.concatenate([np.abs(off), np.full(len(pairs) - len(told), np.inf)])
    middle = float(np.median(every))
    return {
        "grasps": len(pairs),
        "told": len(told),
        "median_error_percent": 100.0 * middle if np.isfinite(middle) else None,
        "bias_percent": float(100.0 * np.median(off)),
        "errors_percent": [
            round(float(100.0 * each), 2) if np.isfinite(each) else None for each in every
        ],
        "interval_holds": sum(each.low <= true <= each.high for true, each in told) / len(pairs),
        "interval_width": float(np.median([each.high / each.low for _, each in told])),
    }
