"""The size at which an effect is detected, by simulation at sizes ever nearer to it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.oracle.bench import Bench
from benchmarks.oracle.discriminant import Discriminant, needed
from benchmarks.truth.effects import SIZES
from benchmarks.truth.size import Size
from hannes.errors import ComputationFailed

NEAR = 1.12  # ratio within which the effect is as good as proportional to its size
NEARBY = 1.3  # ratio from which on all hands are asked
MOST_STEPS = 9
FARTHEST = 30.0  # ratio of one step to the next
FIGURES = 3  # significant, of a size that is simulated
Change = Callable[[float, int], np.ndarray]  # size, number of hands -> (hands, n)


@dataclass(frozen=True)
class Smallest:
    """Smallest detectable sizes (SI, positive) by sign; None: beyond the physical range."""

    name: str
    size: Size
    found: dict[str, float | None]

    @property
    def u(self) -> float | None:
        """The larger of both signs."""
        values = list(self.found.values())
        return None if None in values else max(values)


def smallest(
    name: str, bench: Bench, test: Discriminant, hands: int, begin: float | None = None
) -> Smallest:
    """Search both signs where the effect has both; from `begin` where given."""
    size = SIZES[name]
    signs = {"plus": 1.0} | ({"minus": -1.0} if size.low < 0.0 else {})
    middle = np.sqrt(max(size.low, 0.02 * size.high) * size.high)
    found = {}
    for told, sign in signs.items():

        def change(u: float, count: int, sign: float = sign) -> np.ndarray:
            return np.array([bench.change(name, sign * u, k) for k in range(count)])

        found[told] = searched(change, test, size.high, begin or middle, hands)
    return Smallest(name, size, found)


def searched(change: Change, test: Discriminant, most: float, u: float, hands: int) -> float | None:
    """The size that is detected, or None where that is beyond `most`; the search begins at `u`.

    One hand tells the order of magnitude; all of them have the last word.
    """
    count = 1
    for _ in range(MOST_STEPS):
        u = float(f"{min(u, most):.{FIGURES}g}")
        try:
            times = needed(*test.scores(change(u, count)))
        except ComputationFailed:  # a hand with so much of it does not move: surely detected
            times = 1.0 / FARTHEST
        if 1.0 / NEARBY < times < NEARBY and count < hands:
            count = hands
            times = needed(*test.scores(change(u, count)))
        if u == most and times > 1.0 and count == hands:
            return None
        if 1.0 / NEAR < times < NEAR and count == hands:
            return u * times
        count = hands if u == most and times > 1.0 else count
        u *= float(np.clip(times, 1.0 / FARTHEST, FARTHEST))
    return u
