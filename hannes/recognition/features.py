"""Causal features of a grasp from motor current, position and reference.

The samples are read once, in order, so a feature cannot depend on later samples. A contact is
detected where the current rises above its recent minimum. The travel is then counted from where the
rise began.
"""

import math

import numpy as np

from hannes.core.kernels.jit import entry, kernel
from hannes.dataset.touch_seen import MEMORY, MOVED, SMOOTH, STARTING, least_before, rise_began

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
    "rise_at_1",  # A, when the travel passed each of LEVELS; before, predicted by the secant
    "rise_at_2",
    "rise_at_3",
    "rise_at_4",
)
# Places of what is known since the touch.
START, FREE, FREE_SPEED, PEAK, FARTHEST, WORK, STEEPEST, LAST = range(8)
BEGUN, TOUCH, ROW = range(3)  # places of: sample from which a touch counts, of the touch, next row


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


@kernel
def _begin(known, current, position, touch, size, dt):
    """Note what was at the touch: position, free current, free speed."""
    known[START], known[LAST], known[FREE] = position[touch], position[touch], current
    if touch >= size:
        known[FREE_SPEED] = _line(position, touch, size, dt)[1]


@kernel
def _go_on(known, passed, current, position):
    """Take in one sample after the touch."""
    rise, travel = current - known[FREE], position - known[START]
    known[WORK] += rise * (position - known[LAST])
    known[LAST] = position
    known[PEAK], known[FARTHEST] = max(known[PEAK], rise), max(known[FARTHEST], travel)
    for k in range(passed.size):
        if passed[k] < 0.0 and travel >= LEVELS[k]:
            passed[k] = max(rise, 0.0)


@kernel
def _of_window(current, position, reference, end, size, dt, out):
    """Features of the window alone, and zeros for those of the grasp."""
    out[:] = 0.0
    out[0], out[1] = _line(current, end, size, dt)
    place, out[2] = _line(position, end, size, dt)
    asked, out[3] = _line(reference, end, size, dt)
    out[4] = asked - place
    out[5] = _line(current, end - size, size, dt)[0]
    out[6] = _line(position, end - size, size, dt)[1]


@kernel
def _of_grasp(known, passed, position, since, whole, out):
    """Features of what came since the touch; `whole`: the window lies after it."""
    current, slope, speed = out[0], out[1], out[2]
    peak, farthest = known[PEAK], known[FARTHEST]
    rise, travel, secant = (
        current - known[FREE],
        position - known[START],
        peak / max(farthest, 0.05),
    )
    tangent = _tangent(slope, speed)
    if speed > 0.3 and whole:
        known[STEEPEST] = max(known[STEEPEST], tangent)
    out[7], out[8], out[9], out[10], out[11] = known[FREE], known[FREE_SPEED], since, rise, travel
    out[12], out[13] = rise / max(travel, 0.05), tangent
    out[14] = speed / max(known[FREE_SPEED], 1.0)
    out[15], out[16], out[17], out[18] = peak, farthest, secant, known[WORK]
    out[19] = known[WORK] / max(farthest, 0.1) ** 2
    out[20], out[21], out[22] = peak - rise, known[START], known[STEEPEST]
    for k in range(passed.size):
        out[23 + k] = passed[k] if passed[k] >= 0.0 else LEVELS[k] * secant


@kernel
def _look(position, level, n, first, places, known, size, dt):
    """Look for the touch at sample n, not before sample `first`; return what counts as free."""
    least = least_before(level, first, n)
    touch = rise_began(level, least, first, n)
    if touch >= 0:
        places[TOUCH] = touch
        _begin(known, least, position, touch, size, dt)
    return least


@kernel
def _read(current, position, reference, dt, size, ends, rows, span, memory):
    """Read the samples from span[0] up to span[1], and fill the rows of windows that end there.

    memory: what is kept from sample to sample: level (n,), known (8,), passed (LEVELS,), places
    (BEGUN, TOUCH, ROW), total (1,).
    """
    level, known, passed, places, total = memory
    smooth, rest, starting = max(1, round(SMOOTH / dt)), round(MEMORY / dt), round(STARTING / dt)
    for n in range(span[0], span[1]):
        total[0] += current[n] - (current[n - smooth] if n >= smooth else 0.0)
        level[n] = least = total[0] / min(n + 1, smooth)
        if places[BEGUN] < 0 and abs(position[n] - position[0]) > MOVED:
            places[BEGUN] = n + starting
        if places[TOUCH] < 0 and 0 <= places[BEGUN] < n:
            first = max(places[BEGUN], n - rest)
            least = _look(position, level, n, first, places, known, size, dt)
        touch = places[TOUCH]
        if touch >= 0:
            _go_on(known, passed, level[n], position[n])
        while places[ROW] < ends.size and ends[places[ROW]] == n + 1:
            if n + 1 >= 2 * size:
                out = rows[places[ROW]]
                _of_window(current, position, reference, n + 1, size, dt, out)
                out[7], out[8], out[10], out[21] = least, out[2], level[n] - least, position[n]
                if touch >= 0:
                    whole = n + 1 - touch >= size
                    _of_grasp(known, passed, position[n], (n - touch) * dt, whole, out)
            places[ROW] += 1


@entry
def go_on(current, position, reference, dt, size, ends, rows, span, memory):
    """Go on with `fill` where it stopped: samples from span[0] up to span[1]; see `_read`."""
    _read(current, position, reference, dt, size, ends, rows, span, memory)


@entry
def fill(current, position, reference, dt, size, ends, rows):
    """Fill `rows` (m, NAMES) with the features at the samples before each of `ends` (ascending).

    Samples come every `dt` [s]; windows have `size` samples. Rows before two whole windows stay
    as they are.
    """
    places = np.full(3, -1)
    places[ROW] = 0
    memory = (
        np.zeros(current.size), np.zeros(8), np.full(len(LEVELS), -1.0), places, np.zeros(1)
    )  # fmt: skip
    _read(current, position, reference, dt, size, ends, rows, (0, current.size), memory)
