"""When the hand lets go of what it held, and when it turns to close again: a new grasp then begins.

While it opens, current and travel say nothing of an object, and what was recognised before is over.
"""

RETREAT = 0.3  # rad behind the touch at which what was held is let go
TURN = 0.1  # rad by which the hand must close again


class Release:
    """Follows the shaft [rad]; `is_open` from the letting go until the next grasp begins."""

    def __init__(self) -> None:
        self.is_open = False
        self._lowest = 0.0

    def lets_go(self, touch: float, position: float) -> bool:
        """Whether what was touched at `touch` is let go at `position`, which is noted."""
        if position < touch - RETREAT:
            self.is_open, self._lowest = True, position
            return True
        return False

    def begins(self, position: float) -> bool:
        """Take a sample's position; whether a new grasp begins with it."""
        if not self.is_open:
            return False
        self._lowest = min(self._lowest, position)
        self.is_open = position < self._lowest + TURN
        return not self.is_open
