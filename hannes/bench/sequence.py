"""Which sequence numbers came: every frame once, and what is missing as intervals."""

WIDTH = 1 << 32
FURTHEST = 1 << 20  # a jump ahead beyond this is a restarted board, not a gap


class Received:
    """Sequence numbers of one sender: `accept` says whether a frame is new.

    A frame that comes late, because it was sent again, fills its gap. Memory stays bounded by the
    number of gaps.
    """

    def __init__(self) -> None:
        self._next: int | None = None
        self._gaps: list[tuple[int, int]] = []

    def accept(self, sequence: int) -> bool:
        """Note `sequence`; False where it came before."""
        if self._next is None:
            self._next = sequence + 1
            return True
        ahead = (sequence - self._next) % WIDTH
        if ahead < FURTHEST:
            if ahead:
                self._gaps.append((self._next % WIDTH, sequence % WIDTH))
            self._next = (sequence + 1) % WIDTH
            return True
        return self._fill(sequence)

    def _fill(self, sequence: int) -> bool:
        """Take a late frame out of the gap in which it lies."""
        for k, (start, stop) in enumerate(self._gaps):
            if (sequence - start) % WIDTH < (stop - start) % WIDTH:
                parts = [(start, sequence), ((sequence + 1) % WIDTH, stop)]
                self._gaps[k : k + 1] = [part for part in parts if part[0] != part[1]]
                return True
        return False

    @property
    def missing(self) -> tuple[tuple[int, int], ...]:
        """Intervals of numbers that never came: first, and the one after the last."""
        return tuple(self._gaps)
