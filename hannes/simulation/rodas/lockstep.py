"""Several grasps by the steps of another, all at once; text like step.py, for lanes.

Numbers that differ from grasp to grasp are compiled to vectors with a lane for each; time and step
are the same for all.
"""

import numpy as np

from hannes.simulation.rodas.coefficients import (
    COUPLING,
    DRIFT,
    FRESH,
    GAMMA,
    LOOK,
    NODES,
    STAGE,
    STAGES,
)
from hannes.simulation.rodas.linear_algebra import (
    add_scaled,
    combine,
    copy_to,
    interpolate_piece,
    scaled_size,
)
from hannes.simulation.rodas.step import DOUBT, HOPELESS, MOST_STAGES, keep_piece


def in_step(problem, data, method, rtol, atol, path, first, last, times, filled, rows):
    """Take steps `first` + 1 to `last` of `path`, up to one that some lane misses.

    `data.error` is that of the last one; where it is 1 or more, that step is not the lane's, whose
    state before it is in `data.piece[0]`.
    path (n,): number of steps, and their ends; rows (samples, states) from `filled` on.
    """
    y, piece, taken = data.state[0], data.piece, first
    for place in range(first, last):
        start = path[place] if place > 0 else 0.0
        end = path[place + 1]
        h = end - start
        error, _, _ = stride(problem, data, method, start, h, end, y, rtol, atol, data.work)
        data.error[0] = error
        keep_piece(method, piece, data.work)
        copy_to(piece[0], y)
        copy_to(y, data.work[MOST_STAGES + 2])
        while filled < times.size and times[filled] < end:
            x = (times[filled] - start) / (end - start)
            interpolate_piece(x, piece, data.state, rows[filled])
            filled += 1
        taken += 1
        if any_lane(data.alive[0] > 0.0 and not error < 1.0):
            break
    return taken


def stride(problem, data, method, t, h, bound, y, rtol, atol, work):
    """One step from t to t + h, as `step` attempts it.

    Error in units of the tolerance; what `crossing` said; whether `attempt` would have given up.
    """
    rates, drift, moved = work[MOST_STAGES], work[MOST_STAGES + 1], work[MOST_STAGES + 2]
    b, value = work[MOST_STAGES + 3], work[MOST_STAGES + 4]
    problem.slope(t, y, rates, data)
    problem.mark(y, data)
    problem.linearise(t, y, rates, drift, data)
    problem.decompose(1.0 / (GAMMA[method] * h), data)
    work[1:MOST_STAGES] = 0.0
    copy_to(work[0], rates)
    add_scaled(work[0], h * DRIFT[method, 0], drift)
    problem.resolve(work[0], data)
    copy_to(value, rates)
    ahead, hopeless = 1.0, False
    for stage in range(1, STAGES[method]):
        if FRESH[method, stage]:
            combine(moved, y, 0.0, drift, 1.0, STAGE[method, stage], work)
            now = t + NODES[method, stage] * h
            if (now - bound) * h >= 0.0:
                now = np.nextafter(bound, t)  # there f may jump
            problem.slope(now, moved, value, data)
        combine(b, value, h * DRIFT[method, stage], drift, 1.0 / h, COUPLING[method, stage], work)
        problem.resolve(b, data)
        copy_to(work[stage], b)
        if stage == LOOK[method]:
            if stage == 1:
                add_scaled(b, 2.0, work[0])
            else:
                ahead = problem.crossing(moved, data)
            looked = scaled_size(b, y, moved, rtol, atol, value)
            if (ahead <= 1.0 or stage == 1) and not looked < HOPELESS[method]:
                hopeless = True
    last = work[STAGES[method] - 1]
    add_scaled(moved, 1.0, last)
    error = scaled_size(last, y, moved, rtol, atol, value)
    if ahead < 1.0:
        error *= DOUBT
    return np.inf if hopeless else error, ahead, hopeless


def any_lane(truth):
    """Whether it is true in any lane; plain Python has one."""
    return truth


def of_lane(numbers, lane):
    """One lane's part of an array of all; plain Python has one."""
    return numbers
