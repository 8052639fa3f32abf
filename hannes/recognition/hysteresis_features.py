"""What the current was as the shaft passed the same angles closing and opening: of a whole grasp.

Friction, and a gear that loses a share of its load, add to the current while the hand closes and
take from it while it opens; the elastic part of what is held pulls the same both ways. So the two
together tell more of the force than how the hand let go does. They are known once the hand has
come back and holds nothing any more.
"""

import numpy as np

from hannes.recognition.features import NAMES as OF_WINDOW
from hannes.recognition.features import SMOOTH
from hannes.recognition.windowing import Cut

SHORT = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5)  # rad short of the farthest, at the output shaft
NAMES = (
    "farthest",  # rad, at the output shaft
    "farthest_since",  # s from the touch
    "rise_at_farthest",  # A above the free current
    "squeeze",  # rad from the touch to the farthest
    *(f"closing_{1e3 * short:.0f}_mrad" for short in SHORT),  # A above it, short by so much
    *(f"opening_{1e3 * short:.0f}_mrad" for short in SHORT),  # A
)
WHOLE = (*OF_WINDOW, *NAMES)  # features of a grasp
FREE, TOUCH, SINCE = (OF_WINDOW.index(n) for n in ("free_current", "touch_position", "since"))


def of_grasp(samples: np.ndarray, windows: np.ndarray, last: int, cut: Cut) -> np.ndarray:
    """WHOLE of a grasp: features of its last window with something held, then NAMES.

    samples: current, position and reference, shape (n, 3); windows: their features by `cut`, the
    `last` of which is that one. All are NaN where something is held to the end, or never (-1), or
    the hand has not passed the last of SHORT both ways.
    """
    nothing = np.full(len(WHOLE), np.nan)
    if not 0 <= last < len(windows) - 1:
        return nothing
    found = _of_turn(samples, windows[last], int(cut.ends(len(samples))[last]), cut.sampling)
    return nothing if found is None else np.concatenate([windows[last], found])


def _of_turn(
    samples: np.ndarray, window: np.ndarray, end: int, sampling: float
) -> np.ndarray | None:
    from scipy.ndimage import uniform_filter1d

    touch = max(0, end - 1 - round(float(window[SINCE]) * sampling))
    current = uniform_filter1d(samples[:, 0], max(1, round(SMOOTH * sampling)), mode="nearest")
    position, turn = samples[:, 1], touch + int(np.argmax(samples[touch:, 1]))
    farthest, free = position[turn], window[FREE]
    before, after = position[: turn + 1], position[turn:]
    if max(before.min(), after.min()) >= farthest - SHORT[-1]:
        return None
    going = [turn - int(np.argmax(before[::-1] < farthest - short)) for short in SHORT]
    back = [turn + int(np.argmax(after < farthest - short)) for short in SHORT]
    since, squeeze = (turn - touch) / sampling, farthest - window[TOUCH]
    rise = current[turn] - free
    passed = (current[going] - free, current[back])
    return np.concatenate([(farthest, since, rise, squeeze), *passed])
