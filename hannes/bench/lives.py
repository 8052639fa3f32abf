"""A board that began anew: after a reset its numbers and its clock start again."""

from hannes.bench.frames import Frame
from hannes.bench.sequence import FURTHEST, WIDTH

KEPT = 8192  # frames that are remembered: more than a board keeps to send again


class Lives:
    """Notices frames of a new life.

    A frame that is sent again is the same frame. One of a new life has the number of another, or is
    further behind than what a board keeps.
    """

    def __init__(self) -> None:
        self._known: dict[int, Frame] = {}
        self._newest: int | None = None

    def is_new(self, frame: Frame) -> bool:
        """Take a frame; whether the board began anew before it."""
        new = self._newest is not None and self._differs(frame, self._newest)
        if new:
            self._known.clear()
        ahead = 0 if self._newest is None else (frame.sequence - self._newest) % WIDTH
        if new or ahead < FURTHEST:
            self._newest = frame.sequence
        self._known[frame.sequence] = frame
        if len(self._known) > KEPT:
            del self._known[next(iter(self._known))]
        return new

    def _differs(self, frame: Frame, newest: int) -> bool:
        known = self._known.get(frame.sequence)
        if known is not None:
            return known != frame
        ahead = (frame.sequence - newest) % WIDTH
        return FURTHEST <= ahead <= WIDTH - KEPT
