"""Features rounded to few levels, on which trees grow in less than half the time.

A tree sorts a feature in every node: the fewer values it has, the quicker. Each value goes to the
nearest level. scikit-learn splits halfway between the levels that a node has. Where these are
neighbours, rounding divides there too; where a level between is missing, a feature that was not
rounded may go the other way than its level.
"""

import numpy as np

LEVELS = 64  # of a feature: equal shares of the windows about each
MOST_SEEN = 50_000  # windows, evenly among all, of which levels are computed


def rounded(features: np.ndarray, used: np.ndarray) -> np.ndarray:
    """Features (grasps, windows, n), in windows `used` (grasps, windows) to the nearest level."""
    found, rows = features.copy(), features[used]
    shares = (np.arange(LEVELS) + 0.5) / LEVELS
    some = rows[:: -(-len(rows) // MOST_SEEN)]
    for k in range(rows.shape[1]):
        levels = np.unique(np.quantile(some[:, k], shares, method="nearest"))
        between = 0.5 * levels[1:].astype(float) + 0.5 * levels[:-1]
        rows[:, k] = levels[np.searchsorted(between, rows[:, k])]
    found[used] = rows
    return found
