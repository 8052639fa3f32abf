"""What motor current, position and reference tell up to a moment: causal features of a grasp.

All of it goes through the samples once, in order, so that a feature cannot know what comes after.
A touch is found where the current has risen above the least of the last moments; the position is
then counted from where the rise began.
"""

import math

import numpy as np

from hannes._jit import entry, kernel

CHANNELS = ("current", "position", "reference")
LEVELS = (0.25, 0.5, 1.0, 1.5)  # rad beyond the touch, at the output shaft
NAMES = (
    "current",  # A, mean of the window, as all of these without a word
    "current_slope",  # A/s, least squares over the window
    "speed",  # rad/s, likewise
    "reference_speed",  # rad/s, likewise
    "lag",  # rad, reference less position
    "current_before",  # A, of the window before
    "speed_before",  # rad/s, of the window before
    "free_current",  # A, before the touch
    "free_speed",  # rad/s, before the touch
    "since",  # s from the touch, 0 before
    "rise",  # A above the free current
    "travel",  # rad from the touch
    "secant",  # A/rad, rise over travel
    "tangent",  # A/rad, slope of current over speed
    "slowing",  # 1, speed over free speed
    "peak_rise",  # A, most so far
    "peak_travel",  # rad, most so far
    "peak_secant",  # A/rad, of these two
    "work",  # A rad, rise times travel since the touch, summed
    "work_over_square",  # A/rad, by the square of the most travel
    "fall",  # A below the peak
    "touch_position",  # rad, at the output shaft; before a touch where it is now
    "steepest",  # A/rad, most tangent so far while closing
    "rise_at_1",  # A, when the travel passed each of LEVELS; before, what the secant promises
    "rise_at_2",
    "rise_at_3",
    "rise_at_4",
)
MEMORY = 0.15  # s in which the least current counts as free
SMOOTH = 0.01  # s, of the current that finds the touch
STEP = 0.06  # A of rise that tell a touch
BACK = 0.02  # A of rise from which the travel counts
STARTING = 0.06  # s after the first motion in which the current only accelerates the hand
MOVED = 0.05  # rad


@kernel
def _line(values, end, size, dt):
    """Mean and least-squares slope (per s) of the `size` samples before `end`."""
    middle, total, moment, square = 0.5 * (size - 1), 0.0, 0.0, 0.0
    for k in range(size):
        away = k - middle
        total += values[end - size + k]
        moment += away * values[end - size + k]
        square += away * away
    return total / size, moment / (square * dt)


@kernel
def _tangent(slope, speed):
    """Slope of current over position (A/rad) where the shaft moves, bounded where it stands."""
    return slope / math.copysign(max(abs(speed), 0.3), speed)


@entry
def fill(current, position, reference, dt, size, ends, rows):
    """Fill `rows` (m, NAMES) with the features at the samples before each of `ends` (ascending).

    Samples come every `dt` [s]; windows have `size` samples. Rows before two whole windows stay
    as they are.
    """
    smooth, memory, starting = max(1, round(SMOOTH / dt)), round(MEMORY / dt), round(STARTING / dt)
    count = current.size
    level = np.zeros(count)  # current, smoothed over what was just seen
    begun, touch, start, free, free_speed = -1, -1, 0.0, 0.0, 0.0
    peak, farthest, work, steepest, last = 0.0, 0.0, 0.0, 0.0, 0.0
    passed = np.full(len(LEVELS), -1.0)
    running, row, least = 0.0, 0, 0.0
    for n in range(count):
        running += current[n]
        if n >= smooth:
            running -= current[n - smooth]
        level[n] = running / min(n + 1, smooth)
        if begun < 0 and abs(position[n] - position[0]) > MOVED:
            begun = n
        if touch < 0:
            least = level[n]
        if touch < 0 and begun >= 0 and n > begun + starting:
            first = max(begun + starting, n - memory)
            least = level[first]
            for k in range(first, n):
                least = min(least, level[k])
            if level[n] > least + STEP:
                touch = n
                while touch > first and level[touch] > least + BACK:
                    touch -= 1
                start, free = position[touch], least
                if touch >= size:
                    free_speed = _line(position, touch, size, dt)[1]
                last = start
        if touch >= 0:
            rise, travel = level[n] - free, position[n] - start
            work += rise * (position[n] - last)
            last = position[n]
            peak, farthest = max(peak, rise), max(farthest, travel)
            for k in range(len(LEVELS)):
                if passed[k] < 0.0 and travel >= LEVELS[k]:
                    passed[k] = max(rise, 0.0)
        while row < ends.size and ends[row] == n + 1:
            if n + 1 >= 2 * size:
                out = rows[row]
                mean, slope = _line(current, n + 1, size, dt)
                place, speed = _line(position, n + 1, size, dt)
                asked, reference_speed = _line(reference, n + 1, size, dt)
                out[0], out[1], out[2], out[3], out[4] = mean, slope, speed, reference_speed, 0.0
                out[4] = asked - place
                out[5] = _line(current, n + 1 - size, size, dt)[0]
                out[6] = _line(position, n + 1 - size, size, dt)[1]
                for k in range(7, len(NAMES)):
                    out[k] = 0.0
                out[7], out[8], out[10], out[21] = least, speed, level[n] - least, position[n]
                if touch >= 0:
                    rise, travel = mean - free, position[n] - start
                    if speed > 0.3 and n + 1 - touch >= size:
                        steepest = max(steepest, _tangent(slope, speed))
                    secant = peak / max(farthest, 0.05)
                    out[7], out[8], out[9] = free, free_speed, (n - touch) * dt
                    out[10], out[11] = rise, travel
                    out[12] = rise / max(travel, 0.05)
                    out[13] = _tangent(slope, speed)
                    out[14] = speed / max(free_speed, 1.0)
                    out[15], out[16], out[17], out[18] = peak, farthest, secant, work
                    out[19] = work / max(farthest, 0.1) ** 2
                    out[20], out[21], out[22] = peak - rise, start, steepest
                    for k in range(len(LEVELS)):
                        promised = LEVELS[k] * secant
                        out[23 + k] = passed[k] if passed[k] >= 0.0 else promised
            row += 1
