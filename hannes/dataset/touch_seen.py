"""The touch of an object as the motor current shows it, from which recognition counts.

It is where the current rises above its recent minimum; the travel then counts from where that rise
began. What a policy does in a grasp follows from this touch, so that data sets can limit a command
by it too.
"""

import numpy as np

from hannes.core.kernels.jit import entry, kernel

MEMORY = 0.15  # s in which the least current counts as free
SMOOTH = 0.01  # s, of the current that finds the touch
STEP = 0.06  # A of rise that detect a touch
BACK = 0.02  # A of rise from which the travel counts
STARTING = 0.06  # s after the first motion in which the current only accelerates the hand
MOVED = 0.05  # rad


@kernel
def least_before(level, first, end):
    """Least of the smoothed current from sample `first` to `end`, which counts as free."""
    least = level[first]
    for k in range(first, end):
        least = min(least, level[k])
    return least


@kernel
def rise_began(level, least, first, n):
    """Sample from which the current rose, where sample n lies STEP above `least`; -1 elsewhere."""
    if level[n] <= least + STEP:
        return -1
    touch = n
    while touch > first and level[touch] > least + BACK:
        touch -= 1
    return touch


@entry
def _found(current, position, dt):
    """Sample that shows the touch, and that of the touch; -1 each where there is none."""
    smooth, rest, starting = max(1, round(SMOOTH / dt)), round(MEMORY / dt), round(STARTING / dt)
    level, total, begun = np.zeros(current.size), 0.0, -1
    for n in range(current.size):
        total += current[n] - (current[n - smooth] if n >= smooth else 0.0)
        level[n] = total / min(n + 1, smooth)
        if begun < 0 and abs(position[n] - position[0]) > MOVED:
            begun = n + starting
        if 0 <= begun < n:
            first = max(begun, n - rest)
            touch = rise_began(level, least_before(level, first, n), first, n)
            if touch >= 0:
                return n, touch
    return -1, -1


def seen_touch(current: np.ndarray, position: np.ndarray, dt: float) -> tuple[int, int] | None:
    """Samples that shows the touch first, and of the touch; None where no rise shows one.

    current [A] and position [rad] have shape (n,), a sample every `dt` [s].
    """
    seen, touch = _found(np.ascontiguousarray(current), np.ascontiguousarray(position), dt)
    return (int(seen), int(touch)) if touch >= 0 else None
