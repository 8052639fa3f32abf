"""Which sequence numbers came: every frame once, and what is missing as intervals."""

from bisect import bisect_right
from operator import itemgetter

WIDTH = 1 << 32
MOST_GAPS = 4096  # twice what boards keep to be sent again
FURTHEST = 1 << 20  # a jump ahead beyond this is a board that began anew, not a gap


class Received:
    """Sequence numbers of one sender: `accept` says whether a frame is new.

    A frame that comes late, because it was sent again, fills its gap. Of more than MOST_GAPS the
    first are forgotten: no board has their frames any more.
    """

    def __init__(self) -> None:
        # Numbers go on beyond WIDTH here, so that gaps are in order.
        self._next: int | None = None
        self._gaps: list[tuple[int, int]] = []

    def accept(self, sequence: int) -> bool:
        """Note `sequence`; False where it came before."""
        if self._next is None:
            self._next = sequence + 1
            return True
        ahead = (sequence - self._next) % WIDTH
        if ahead >= FURTHEST:
            return self._fill(self._next + ahead - WIDTH)
        if ahead:
            self._gaps.append((self._next, self._next + ahead))
            del self._gaps[:-MOST_GAPS]
        self._next += ahead + 1
        return True

    def _fill(self, number: int) -> bool:
        """Take a late frame out of the gap in which it lies."""
        k = bisect_right(self._gaps, number, key=itemgetter(0)) - 1
        if k < 0 or number >= self._gaps[k][1]:
            return False
        start, stop = self._gaps[k]
        parts = [(start, number), (number + 1, stop)]
        self._gaps[k : k + 1] = [part for part in parts if part[0] != part[1]]
        return True

    @property
    def missing(self) -> tuple[tuple[int, int], ...]:
        """Intervals of numbers that never came: first, and the one after the last."""
        return tuple((start % WIDTH, stop % WIDTH) for start, stop in self._gaps)
