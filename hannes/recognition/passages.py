"""What the current was as the shaft passed the same angles closing and opening: of a whole grasp.

Friction, and a gear that loses a share of its load, add to the current while the hand closes and
take from it while it opens; what is held pulls the same both ways. So the two together tell more
of the force than how the hand let go does. They are known once the hand has come back.
"""

import numpy as np

from hannes.recognition.features import NAMES as OF_WINDOW
from hannes.recognition.features import SMOOTH

SHORT = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5)  # rad short of the farthest, at the output shaft
NAMES = (
    "farthest",  # rad, at the output shaft
    "farthest_at",  # s from the first sample
    "most_rise",  # A above the free current
    "rise_at_farthest",  # A, likewise
    "squeeze",  # rad from the touch to the farthest
    *(f"closing_{k}" for k in range(1, len(SHORT) + 1)),  # A above it, at each of SHORT
    *(f"opening_{k}" for k in range(1, len(SHORT) + 1)),  # A
)
WHOLE = len(OF_WINDOW) + len(NAMES)  # features of a grasp
FREE, TOUCH = OF_WINDOW.index("free_current"), OF_WINDOW.index("touch_position")


def of_grasp(samples: np.ndarray, window: np.ndarray, sampling: float) -> np.ndarray:
    """Features of a whole grasp: of its last window with something held, then NAMES.

    samples: current, position and reference, shape (n, 3), at `sampling` [Hz]; window: features
    of that window. All are NaN where the hand has not come back by the last of SHORT.
    """
    position, size = samples[:, 1], max(1, round(SMOOTH * sampling))
    current = np.convolve(samples[:, 0], np.full(size, 1.0 / size))[: position.size]
    turn, free = int(np.argmax(position)), window[FREE]
    farthest = position[turn]
    if position[turn:].min() >= farthest - SHORT[-1]:
        return np.full(WHOLE, np.nan)
    before, after = position[: turn + 1], position[turn:]
    going = [_last(before < farthest - short) for short in SHORT]
    back = [turn + int(np.argmax(after < farthest - short)) for short in SHORT]
    of_turn = (
        farthest,
        turn / sampling,
        current.max() - free,
        current[turn] - free,
        farthest - window[TOUCH],
    )
    return np.concatenate([window, of_turn, current[going] - free, current[back]])


def _last(which: np.ndarray) -> int:
    """Place of the last that is true, 0 where none is."""
    return which.size - 1 - int(np.argmax(which[::-1])) if which.any() else 0
