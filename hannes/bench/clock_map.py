"""From the board's clock to the host's: the lower hull of host minus board time.

A frame is late by what the link takes, never early: the true offset lies below all points
(board time, host - board). The line under them that comes closest in the mean is an edge of their
lower convex hull (as Skelton & Moon 1999 estimate one-way delays and clock skew).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ClockMap:
    """host [s] = offset [s] + (1 + drift) * board [s], for frames without delay."""

    offset: float
    drift: float

    def host(self, board: np.ndarray) -> np.ndarray:
        """Host times [s] of board times [s], any shape."""
        return self.offset + (1.0 + self.drift) * board


def clock_map(board: np.ndarray, host: np.ndarray) -> ClockMap:
    """Return the map through the lower hull of `board` and `host` times [s], both (n,), n > 0."""
    start = board[0]
    x, late = board - start, (host - host[0]) - (board - start)
    hull = lower_hull(x, late)
    middle = float(np.mean(x))
    k = int(np.clip(np.searchsorted(x[hull], middle), 1, max(len(hull) - 1, 1)))
    if len(hull) < 2:
        return ClockMap(float(host[0] - start), 0.0)
    first, second = hull[k - 1], hull[k]
    drift = float((late[second] - late[first]) / (x[second] - x[first]))
    at_start = float(late[first] - drift * x[first])
    return ClockMap(float(host[0] + at_start - (1.0 + drift) * start), drift)


def lower_hull(x: np.ndarray, y: np.ndarray) -> list[int]:
    """Places of the points of the lower convex hull of (x, y); x increases. Andrew (1979)."""
    hull: list[int] = []
    for k in range(x.size):
        while len(hull) > 1 and _above(x, y, hull[-2], hull[-1], k):
            hull.pop()
        hull.append(k)
    return hull


def _above(x: np.ndarray, y: np.ndarray, first: int, middle: int, last: int) -> bool:
    """Whether the middle point lies on or above the line from the first to the last."""
    left = (y[middle] - y[first]) * (x[last] - x[first])
    return bool(left >= (y[last] - y[first]) * (x[middle] - x[first]))
