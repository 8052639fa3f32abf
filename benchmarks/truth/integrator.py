"""TR-BDF2 with step control (Bank et al. 1985; Hosea & Shampine 1996): second order, L-stable.

A trapezoidal stage to a share SHARE of the step, then a BDF2 stage to its end, both with the
diagonal DIAGONAL. The unknowns of a stage are speeds and current alone; positions and inner
variables follow from their own relations (`motion.rates`). Newton's method with a differenced
Jacobian that is kept while it converges: the result depends on it only below NEWTON.
"""

from math import sqrt

import numpy as np

from benchmarks.truth._jit import compiled
from benchmarks.truth.linear import factor, solve
from benchmarks.truth.motion import rates
from benchmarks.truth.state import CURRENT, SCALE, SIZE, WATCHED

SHARE = 2.0 - sqrt(2.0)
DIAGONAL = 1.0 - 1.0 / sqrt(2.0)
WEIGHT = sqrt(2.0) / 4.0
# Second-order weights less those of the third-order formula on the same three rates.
ERROR = ((4.0 * WEIGHT - 1.0) / 3.0, -1.0 / 3.0, 2.0 * DIAGONAL / 3.0)
NEWTON = 1e-6  # in units of SCALE
HOPELESS = 1e30


@compiled
def reference_at(knots, t):
    """Piecewise linear reference (rows: s, motor-side rad), constant outside."""
    if t <= knots[0, 0]:
        return knots[0, 1]
    for k in range(1, knots.shape[0]):
        if t <= knots[k, 0]:
            part = (t - knots[k - 1, 0]) / (knots[k, 0] - knots[k - 1, 0])
            return knots[k - 1, 1] + part * (knots[k, 1] - knots[k - 1, 1])
    return knots[-1, 1]


@compiled
def workspace(n):
    """Matrix, pivots, by_speed, by_place; rates twice; state and start moved; residual."""
    return (
        np.zeros((n, n)),
        np.zeros(n, np.int64),
        np.zeros((n, n)),
        np.zeros((n, n)),
        np.zeros(SIZE),
        np.zeros(SIZE),
        np.zeros(SIZE),
        np.zeros(SIZE),
        np.zeros(n),
    )


@compiled
def linearise(h, start, gain, reference, drive, y, unknowns, work):
    """Differences the unknowns' rates at y: by_speed at fixed positions, by_place with them."""
    _, _, by_speed, by_place, base, moved, point, shifted, _ = work
    duty, is_sampled = drive
    rates(h, start, gain, reference, duty, is_sampled, y, base)
    for j in range(unknowns.shape[0]):
        place, follows = unknowns[j]
        width = 1e-6 * SCALE[place]
        for i in range(SIZE):
            point[i], shifted[i] = y[i], start[i]
        point[place] += width
        if follows >= 0:
            shifted[follows] -= gain * width
        rates(h, shifted, gain, reference, duty, is_sampled, point, moved)
        for i in range(unknowns.shape[0]):
            by_speed[i, j] = (moved[unknowns[i, 0]] - base[unknowns[i, 0]]) / width
        if follows >= 0:
            width = 1e-6 * SCALE[follows]
            shifted[follows], point[place] = start[follows] + width, y[place]
            rates(h, shifted, gain, reference, duty, is_sampled, point, moved)
            for i in range(unknowns.shape[0]):
                by_place[i, j] = (moved[unknowns[i, 0]] - base[unknowns[i, 0]]) / width


@compiled
def compose(gain, work):
    """Factors of a stage's matrix, I - gain by_speed - gain^2 by_place."""
    lu, pivots, by_speed, by_place = work[0], work[1], work[2], work[3]
    for i in range(pivots.size):
        for j in range(pivots.size):
            lu[i, j] = -gain * (by_speed[i, j] + gain * by_place[i, j])
        lu[i, i] += 1.0
    factor(lu, pivots)


@compiled
def stage(h, start, gain, reference, drive, y, dy, unknowns, work):
    """Solves y = start + gain y' from the guess in y's unknowns; (converged, Jacobian worn out)."""
    lu, pivots, residual = work[0], work[1], work[8]
    last, since = HOPELESS, 0
    for count in range(40):
        rates(h, start, gain, reference, drive[0], drive[1], y, dy)
        for i in range(pivots.size):
            place = unknowns[i, 0]
            residual[i] = start[place] + gain * dy[place] - y[place]
        solve(lu, pivots, residual)
        size = 0.0
        for i in range(pivots.size):
            place = unknowns[i, 0]
            size = max(size, abs(residual[i]) / SCALE[place])
            y[place] += residual[i]
        if size < NEWTON:
            for i in range(pivots.size):
                place = unknowns[i, 0]
                dy[place] = (y[place] - start[place]) / gain
            return True, count > 4
        if not size < HOPELESS:  # also where it is not a number
            return False, True
        since += 1
        if since > 1 and size > 0.3 * last:
            linearise(h, start, gain, reference, drive, y, unknowns, work)
            compose(gain, work)
            since = 0
        last = size
    return False, True


@compiled
def attempt(h, y, dy, t, size, knots, drive, unknowns, stages, work):
    """One step of `size` from y with rates dy, its result in the last two of stages.

    stages: five times SIZE: start, middle, its rates, end, its rates.
    Returns the estimated error in units of SCALE (HOPELESS: no convergence) and whether the
    Jacobian is worn out.
    """
    start, middle, middle_rates, end, end_rates = stages
    gain = DIAGONAL * size
    for i in range(SIZE):
        start[i] = y[i] + gain * dy[i]
        middle[i] = y[i] + SHARE * size * dy[i]
    if drive[1]:
        middle[CURRENT] = y[CURRENT]  # its rate is that of a jump
    reference = reference_at(knots, t + SHARE * size)
    good, worn = stage(h, start, gain, reference, drive, middle, middle_rates, unknowns, work)
    if not good:
        return HOPELESS, True
    for i in range(SIZE):
        start[i] = y[i] + size * WEIGHT * (dy[i] + middle_rates[i])
        end[i] = y[i] + (middle[i] - y[i]) / SHARE
    reference = reference_at(knots, t + size)
    good, also = stage(h, start, gain, reference, drive, end, end_rates, unknowns, work)
    if not good:
        return HOPELESS, True
    return error(dy, middle_rates, end_rates, size, drive[1], unknowns, work), worn or also


@compiled
def error(first, middle, last, size, is_sampled, unknowns, work):
    """Largest estimated error of unknowns and watched positions, in units of SCALE.

    That of the unknowns is damped as the step damps it, by the stage's own matrix. A sampled
    current is not watched: see `advance`.
    """
    lu, pivots, residual = work[0], work[1], work[8]
    c1, c2, c3 = size * ERROR[0], size * ERROR[1], size * ERROR[2]
    for i in range(pivots.size):
        k = unknowns[i, 0]
        residual[i] = c1 * first[k] + c2 * middle[k] + c3 * last[k]
    solve(lu, pivots, residual)
    most = 0.0
    for i in range(pivots.size):
        k = unknowns[i, 0]
        if not (is_sampled and k == CURRENT):
            most = max(most, abs(residual[i]) / SCALE[k])
    for i in range(WATCHED.size):
        k = WATCHED[i]
        most = max(most, abs(c1 * first[k] + c2 * middle[k] + c3 * last[k]) / SCALE[k])
    return most


@compiled
def prepare(h, y, t, gain, knots, drive, unknowns, stages, work, pace):
    """Makes the stages' matrix ready for `gain`."""
    if pace[2] != 0.0:
        reference = reference_at(knots, t)
        for i in range(SIZE):
            stages[0][i], stages[1][i] = y[i], y[i]
        linearise(h, stages[0], gain, reference, drive, stages[1], unknowns, work)
        pace[1], pace[2] = 0.0, 0.0
    if not 0.9 < pace[1] / gain < 1.1:
        compose(gain, work)
        pace[1] = gain


@compiled
def advance(h, y, dy, t, duration, knots, drive, control, unknowns, stages, work, pace):
    """Carries y and its rates over `duration` (s); False where no step converges any more.

    Where the controller is sampled, the voltage jumps at the start and the current settles within
    L/R, far below a step. Only its end matters: the motor feels the voltage's integral, not the
    current's way. So the first step is at most 2 L/R and each other at most 2.5 times the one
    before, which leaves below 0.1 % of the jump, and no error of it is estimated.

    control: tolerance in units of SCALE, longest step (s). pace: the step to try next (s), the gain
    of the factored matrix, and whether the Jacobian is worn out.
    """
    tolerance, longest = control
    limit = 2.0 * h.motor_inductance / h.motor_resistance if drive[1] else longest
    done, tries = 0.0, 0
    while done < duration * (1.0 - 1e-9):
        left = duration - done
        size = left / np.ceil(left / min(pace[0], limit) - 1e-9)
        prepare(h, y, t + done, DIAGONAL * size, knots, drive, unknowns, stages, work, pace)
        miss, worn = attempt(h, y, dy, t + done, size, knots, drive, unknowns, stages, work)
        if worn:
            pace[2] = 1.0
        tries += 1
        if miss <= tolerance:
            done, tries = done + size, 0
            for i in range(SIZE):
                y[i], dy[i] = stages[3][i], stages[4][i]
        elif tries > 60:
            return False
        growth = 0.9 * (tolerance / max(miss, 1e-12)) ** (1.0 / 3.0) if miss < HOPELESS else 0.25
        if miss > tolerance or pace[0] <= limit:  # else the limit was what made it so small
            pace[0] = min(size * min(max(growth, 0.2), 4.0), longest)
        if drive[1]:
            limit = 2.5 * size
    return True
