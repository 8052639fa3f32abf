"""The size at which an effect is detected, by simulation at sizes ever nearer to it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.oracle.bench import Bench
from benchmarks.oracle.discriminant import Discriminant, needed
from benchmarks.oracle.shapes import Shape
from benchmarks.truth.hidden import SIZES
from hannes.core.errors import ComputationFailed

NEAR = 1.12  # ratio within which the effect is as good as proportional to its size
NEARBY = 1.3  # ratio from which on all hands are asked
MOST_STEPS = 14
FARTHEST = 30.0  # ratio of one step to the next
FIGURES = 3  # significant, of a size that is simulated
SIGNATURE_HAND, SIGNATURE_HANDS = 1000, 2
Change = Callable[[float, int, int], np.ndarray]  # size, first hand, hands -> (hands, n)


@dataclass(frozen=True)
class Smallest:
    """Smallest detectable sizes (SI, positive) by sign; None: beyond the physical range."""

    found: dict[str, float | None]

    @property
    def u(self) -> float | None:
        """The larger of both signs."""
        values = list(self.found.values())
        return None if None in values else max(values)


def smallest(
    name: str, shape: Shape, bench: Bench, test: Discriminant, hands: int, begin: float | None
) -> Smallest:
    """Search both signs where the effect has both; from `begin` where given."""
    found = {}
    for name_of_sign, (sign, least, most) in SIZES[name].signs.items():
        middle = np.sqrt(max(least, 0.02 * most) * most)

        def change(u: float, first: int, count: int, sign: float = sign) -> np.ndarray:
            return np.array([bench.change(name, sign * u, first + k, shape) for k in range(count)])

        found[name_of_sign] = searched(change, test, most, begin or middle, hands)
    return Smallest(found)


def searched(change: Change, test: Discriminant, most: float, u: float, hands: int) -> float | None:
    """The size that is detected, or None where that is beyond `most`; the search begins at `u`.

    One hand gives the order of magnitude; all of them decide.
    """
    count, low, high = 1, 0.0, np.inf
    for _ in range(MOST_STEPS):
        u = float(f"{min(u, most):.{FIGURES}g}")
        times = needed_times(change, test, most, u, count)
        if (1.0 / NEARBY < times < NEARBY or (u == most and times > 1.0)) and count < hands:
            count, low, high = hands, 0.0, np.inf
            times = needed_times(change, test, most, u, count)
        if u == most and times > 1.0:
            return None
        if 1.0 / NEAR < times < NEAR and count == hands:
            return min(u * times, most)
        low, high = (u, high) if times > 1.0 else (low, u)
        u = u * times if low < u * times < high else float(np.sqrt(low * high))
    return high


def needed_times(change: Change, test: Discriminant, most: float, u: float, count: int) -> float:
    """How many times as large as `u` the effect must be.

    Its signature is what it does to other hands: at four times the size, where the rounding of
    sensors, which no two simulations share, hardly blurs it; or nearer, where it depends on the
    size. The better one counts.
    """
    scored = _made(change, u, 0, count)
    if scored is None:  # a hand with so much of it does not move: surely detected
        return 1.0 / FARTHEST
    times = [FARTHEST]
    for moderate in {float(min(2.0 ** round(np.log2(k * u)), most)) for k in (1.0, 4.0)}:
        made = _made(change, moderate, SIGNATURE_HAND, SIGNATURE_HANDS)
        if made is not None and made.any():
            times.append(needed(*test.scores(made.mean(axis=0), scored)))
    return float(np.clip(min(times), 1.0 / FARTHEST, FARTHEST))


def _made(change: Change, *asked: float) -> np.ndarray | None:
    try:
        return change(*asked)
    except ComputationFailed:
        return None
