"""The method: steps with error control, the same text for every problem.

`problem` stands for four functions over `data`, which holds whatever they need:

    slope(t, y, dy, data)                       fill dy with f(t, y)
    linearise(t, y, rates, drift, data)         keep J = df/dy, fill drift with df/dt; rates = f
    decompose(shift, data)                      factor shift - J
    resolve(b, data)                            replace b by the solution of (shift - J) x = b
    mark(y, data)                               note on which side of each kink of f y lies
    crossing(y, data)                           how far on the way from there to y the first kink
                                                lies, 1 where none is crossed, 2 where none is known

The last two may do nothing and return 2; they follow an evaluation of `slope` at that y.

It may be an object with these methods; for compiled code the text is taken with `problem.`
dropped (see source.py), so that the names are those of the module it lands in.
"""

import math

import numpy as np

from hannes.simulation.rodas.coefficients import (
    COUPLING,
    DENSE,
    DRIFT,
    FRESH,
    GAMMA,
    LOOK,
    LOOSE,
    NODES,
    ORDER,
    STAGE,
    STAGES,
)
from hannes.simulation.rodas.linear_algebra import (
    add_scaled,
    combine,
    copy_to,
    interpolate_piece,
    scaled_size,
    total,
    weigh,
)

MOST_STAGES = 6
WORK = MOST_STAGES + 5  # rows of workspace: all k, f(t, y), df/dt, argument, right-hand side, f
SAFETY, SHRINK, GROW, AGAIN = 0.9, 0.2, 6.0, 1.5  # AGAIN: growth after a rejection
# Size of what is of second order, by method, at which a step is given up before its last stages;
# by Rodas3 only of problems that know of kinks, as else that can be large and right.
HOPELESS = np.array([8.0, 4.0])
BEYOND, ADDED = 1.02, 0.005  # a step that fails at a kink is cut to end just beyond it,
BEFORE = 0.97  # and the second time, where the kink is near its end, before it
DOUBT = 3.0  # what an error estimate may be wrong by across a kink
LEAST = 2e-15  # of the time: the shortest step
TOO_SMALL, NOT_FINITE, TOO_MANY = -1, -2, -3


def advance(problem, data, y, rtol, atol, clock, counts, bounds, ends, pieces, work):
    """Take steps until the last of `bounds` is reached or `pieces` is full; return how many.

    `y` (n,) moves along. `clock`: time, next step (signed; 0: to be chosen), the bound ahead,
    longest step, what `crossing` said; the rest is of whole_tick.py. `counts` grows: evaluations,
    Jacobians, factorings, rejected steps; then a failure's number. No step leads across one of
    `bounds` (b,), on the way in this order. `ends` (m + 1,) and `pieces` (m + 1, 3, n) take each
    step's ends and its dense output.
    """
    taken = 0
    ends[0] = clock[0]
    copy_to(pieces[0, 0], y)
    while taken < ends.size - 1 and clock[0] != bounds[bounds.size - 1]:
        if clock[0] == clock[2]:
            clock[1], clock[2] = 0.0, bound_after(clock[0], bounds)
        if clock[1] == 0.0:
            first_step(problem, data, y, rtol, atol, clock, counts, work)
        failure = step(problem, data, y, rtol, atol, clock, counts, pieces[taken], work)
        if failure != 0:
            counts[4] = failure
            break
        taken += 1
        ends[taken] = clock[0]
        copy_to(pieces[taken, 0], y)
    return taken


def bound_after(time, bounds):
    """The bound that follows the one at `time`."""
    k = 0
    while bounds[k] != time:
        k += 1
    return bounds[k + 1]


def step(problem, data, y, rtol, atol, clock, counts, piece, work):
    """Take one step that is accepted; 0 or a failure."""
    rates, drift, moved = work[MOST_STAGES], work[MOST_STAGES + 1], work[MOST_STAGES + 2]
    t, bound, method = clock[0], clock[2], int(rtol >= LOOSE)
    problem.slope(t, y, rates, data)
    if not math.isfinite(total(rates)):
        return NOT_FINITE
    problem.mark(y, data)
    problem.linearise(t, y, rates, drift, data)
    counts[0] += 1
    counts[1] += 1
    failures, tried, failed, h, error = 0, 0.0, 0.0, 0.0, 0.0
    while True:
        h = clock[1]
        if abs(h) > clock[3]:
            h = math.copysign(clock[3], h)
        if abs(bound - t) <= min(1.01 * abs(h), (1.0 + 1e-9) * clock[3]):
            h = bound - t
        elif not abs(h) > LEAST * abs(t):  # nor where it is no number
            return TOO_SMALL
        problem.decompose(1.0 / (GAMMA[method] * h), data)
        counts[2] += 1
        error = attempt(problem, data, method, t, h, y, rtol, atol, clock, counts, work)
        if clock[4] < 1.0:
            error *= DOUBT
        if error < 1.0:
            break
        shrink = SHRINK
        if error < 1e6:
            order = ORDER[method]
            if failures > 0 and failed < 1e6:
                order = math.log(failed / error) / math.log(tried / h)
            shrink = SAFETY * error ** (-1.0 / min(max(order, 0.5), ORDER[method]))
            shrink = min(max(SHRINK, shrink), 0.9)
        if clock[4] < 1.0 and failures == 0:
            shrink = min(BEYOND * clock[4] + ADDED, 0.95)
        elif 0.5 < clock[4] < 1.0 and failures == 1:
            shrink = BEFORE * clock[4]
        failures, tried, failed = failures + 1, h, error
        counts[3] += 1
        clock[1] = h * shrink
    keep_piece(method, piece, work)
    copy_to(y, moved)
    clock[0] = bound if h == bound - t else t + h
    grow = SAFETY * max(error, 1e-8) ** (-1.0 / ORDER[method])
    clock[1] = h * min(max(grow, SHRINK), AGAIN if failures > 0 else GROW)
    return 0


def attempt(problem, data, method, t, h, y, rtol, atol, clock, counts, work):
    """Compute the stages k and y(t + h); return the error in units of the tolerance."""
    rates, drift, moved = work[MOST_STAGES], work[MOST_STAGES + 1], work[MOST_STAGES + 2]
    b, value = work[MOST_STAGES + 3], work[MOST_STAGES + 4]
    work[1:MOST_STAGES] = 0.0
    copy_to(work[0], rates)
    add_scaled(work[0], h * DRIFT[method, 0], drift)
    problem.resolve(work[0], data)
    copy_to(value, rates)
    for stage in range(1, STAGES[method]):
        if FRESH[method, stage]:
            combine(moved, y, 0.0, drift, 1.0, STAGE[method, stage], work)
            now = t + NODES[method, stage] * h
            if (now - clock[2]) * h >= 0.0:
                now = np.nextafter(clock[2], t)  # there f may jump
            problem.slope(now, moved, value, data)
            counts[0] += 1
        combine(b, value, h * DRIFT[method, stage], drift, 1.0 / h, COUPLING[method, stage], work)
        problem.resolve(b, data)
        copy_to(work[stage], b)
        if stage == LOOK[method]:
            if stage == 1:  # of Rodas4P2, where k_2 = -2 k_1 but for what is of second order
                add_scaled(b, 2.0, work[0])
            else:  # of Rodas3; the other one's short look at kinks costs more than it saves
                clock[4] = problem.crossing(moved, data)
            if clock[4] <= 1.0 or stage == 1:
                if not scaled_size(b, y, moved, rtol, atol, value) < HOPELESS[method]:
                    return np.inf
    last = work[STAGES[method] - 1]
    add_scaled(moved, 1.0, last)
    return scaled_size(last, y, moved, rtol, atol, value)


def keep_piece(method, piece, work):
    """Store the curvature of a step in two rows of its dense output, beside its start."""
    for row in range(2):
        weigh(piece[1 + row], DENSE[method, row], work)


def first_step(problem, data, y, rtol, atol, clock, counts, work):
    """Choose the first step as Hairer, Norsett & Wanner (1993), section II.4, do."""
    rates, other, moved = work[MOST_STAGES], work[MOST_STAGES + 1], work[MOST_STAGES + 2]
    parts = work[MOST_STAGES + 3]
    reach = clock[2] - clock[0]
    problem.slope(clock[0], y, rates, data)
    size = scaled_size(y, y, y, rtol, atol, parts)
    speed = scaled_size(rates, y, y, rtol, atol, parts)
    h = 1e-6 if size < 1e-5 or speed < 1e-5 else 0.01 * size / speed
    h = math.copysign(min(h, abs(reach)), reach)
    if not 0.0 < abs(h) < np.inf:  # nowhere to go, or rates that `step` will refuse
        clock[1] = reach
        return
    copy_to(moved, y)
    add_scaled(moved, h, rates)
    problem.slope(clock[0] + h, moved, other, data)
    counts[0] += 2
    add_scaled(other, -1.0, rates)
    bend = scaled_size(other, y, y, rtol, atol, parts) / abs(h)
    worst = max(speed, bend)
    asked = max(1e-6, abs(h) * 1e-3)
    if 1e-15 <= worst < np.inf:
        asked = (0.01 / worst) ** (1.0 / ORDER[int(rtol >= LOOSE)])
    clock[1] = math.copysign(min(100.0 * abs(h), asked, abs(reach)), reach)


def sample_pieces(times, ends, pieces, rows):
    """Fill rows (k, n) with the solution at `times` (k,); fastest where they are in order."""
    last, at = ends.size - 2, 0
    sign = 1.0 if ends[last + 1] >= ends[0] else -1.0
    for k in range(times.size):
        while at < last and sign * times[k] > sign * ends[at + 1]:
            at += 1
        while at > 0 and sign * times[k] <= sign * ends[at]:
            at -= 1
        x = (times[k] - ends[at]) / (ends[at + 1] - ends[at])
        interpolate_piece(x, pieces[at], pieces[at + 1], rows[k])
