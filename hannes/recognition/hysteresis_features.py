"""Hysteresis features of a whole grasp: current at the same shaft angles, closing and opening.

Friction and load-dependent gear losses add to the current while the hand closes and reduce it
while it opens. The elastic force of the object acts the same both ways. The two currents together
therefore say more about the force than the opening alone. They are known once the hand has opened
again.
"""

import numpy as np

from hannes.dataset.touch_seen import SMOOTH
from hannes.recognition.features import NAMES as OF_WINDOW
from hannes.recognition.windowing import Windowing

SHORT = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5)  # rad before the farthest, at the output shaft
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


def grasp_features(
    samples: np.ndarray, windows: np.ndarray, last: int, windowing: Windowing
) -> np.ndarray:
    """Features WHOLE of a grasp: those of its last window with an object held, then NAMES.

    samples: current [A], position and reference [rad], shape (n, 3); windows: their features by
    `windowing`, of which `last` is that window. All are NaN where an object is held to the end, or
    never (-1), or where the shaft has not passed the last of SHORT both ways.
    """
    nothing = np.full(len(WHOLE), np.nan)
    if not 0 <= last < len(windows) - 1:
        return nothing
    found = _turn_features(
        samples, windows[last], int(windowing.ends(len(samples))[last]), windowing.sampling
    )
    return nothing if found is None else np.concatenate([windows[last], found])


def _turn_features(
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
