"""Several grasps at once, each by its own steps; text like step.py, for lanes.

Each turn is an attempt in all lanes. A lane whose attempt is refused makes the same Jacobian once
more, as the others make theirs. So a lane takes the very steps that `step` takes.
"""

import math

import numpy as np

from hannes.core.kernels.jit import fused
from hannes.simulation.rodas.coefficients import FRESH, LOOK, ORDER, STAGES
from hannes.simulation.rodas.linear_algebra import total
from hannes.simulation.rodas.lockstep import any_lane, of_lane, stride
from hannes.simulation.rodas.step import (
    ADDED,
    AGAIN,
    BEFORE,
    BEYOND,
    GROW,
    LEAST,
    MOST_STAGES,
    SAFETY,
    SHRINK,
    first_step,
    keep_piece,
)

WIDTH = 1  # lanes; filled in
# Evaluations of an attempt by each method, and of one that is given up.
ALL = np.array([float(np.count_nonzero(FRESH[m, 1 : STAGES[m]])) for m in range(2)])
FEW = np.array([float(np.count_nonzero(FRESH[m, 1 : LOOK[m] + 1])) for m in range(2)])


def own_steps(problem, data, method, rtol, atol, bounds, moments, most, rows):
    """Up to `most` turns, fewer where no lane is alive any more; how many.

    `data.clock`: as `advance` has it; `data.tries`: failures of the step that is tried, the last
    step tried, its error; `data.place`: rows filled, bounds passed; `data.failed`: 1 where a lane
    has failed. moments (n,): times of samples, as many in a row as there are lanes; rows
    (lanes n, states): of one grasp after the other the states at them.
    """
    turns = 0
    for _ in range(most):
        one_turn(problem, data, method, rtol, atol, bounds, moments, rows)
        turns += 1
        if not any_lane(data.alive[0] > 0.0):
            break
    return turns


def one_turn(problem, data, method, rtol, atol, bounds, moments, rows):
    """An attempt in all lanes, and what follows from its error."""
    y, piece, clock, work = data.state[0], data.piece, data.clock, data.work
    alive = data.alive[0] > 0.0
    begins = alive and clock[1] == 0.0
    while begins:  # once: so the text for some lanes is all there is
        first_step(problem, data, y, rtol, atol, clock, data.counts, work)
        begins = False
    t, bound, h, small = clock[0], clock[2], clock[1], False
    if abs(h) > clock[3]:
        h = math.copysign(clock[3], h)
    if abs(bound - t) <= min(1.01 * abs(h), (1.0 + 1e-9) * clock[3]):
        h = bound - t
    elif not abs(h) > LEAST * abs(t):
        small = True
    error, ahead, hopeless = stride(problem, data, method, t, h, bound, y, rtol, atol, work)
    keep_piece(method, piece, work)
    failing = alive and (small or not math.isfinite(total(work[MOST_STAGES])))
    taken = alive and not failing and error < 1.0
    tried = alive and not failing and not taken
    count_turn(data, method, alive, hopeless)
    clock[1] = choose_next(data.tries, method, h, error, ahead, tried, taken, clock[1])
    end = t
    if taken:
        end = bound if h == bound - t else t + h
    for i in range(y.size):
        piece[0, i] = y[i]
        y[i] = work[MOST_STAGES + 2, i] if taken else y[i]
    clock[0] = end
    data.begins[0] = t
    fill_rows(data, data.begins, piece, y, moments, rows)
    pass_bound(data, clock, bounds, taken and end == bound, failing)


def count_turn(data, method, alive, hopeless):
    """As `step` and `attempt` do."""
    counts, one = data.counts, 1.0 if alive else 0.0
    new = one if data.tries[0] == 0.0 else 0.0
    evaluations = FEW[method] if hopeless else ALL[method]
    counts[0] += new + one * evaluations
    counts[1] += new
    counts[2] += one


def choose_next(tries, method, h, error, ahead, tried, taken, before):
    """The step to be tried next, see `step`."""
    failures, last, failed = tries[0], tries[1], tries[2]
    order, base = ORDER[method], max(error, 1e-8)
    if not taken:
        base = error
        if failures > 0.0 and failed < 1e6:
            order = math.log(failed / error) / math.log(last / h)
            order = min(max(order, 0.5), ORDER[method])
    size = SAFETY * base ** (-1.0 / order)
    grow = min(max(size, SHRINK), AGAIN if failures > 0.0 else GROW)
    shrink = min(max(SHRINK, size), 0.9) if error < 1e6 else SHRINK
    if ahead < 1.0 and failures == 0.0:
        shrink = min(BEYOND * ahead + ADDED, 0.95)
    elif 0.5 < ahead < 1.0 and failures == 1.0:
        shrink = BEFORE * ahead
    tries[0] = failures + 1.0 if tried else 0.0
    tries[1], tries[2] = h, error
    if taken:
        return h * grow
    return h * shrink if tried else before


def fill_rows(data, begins, piece, y, moments, rows):
    """Samples of each lane's step from where it `begins` to `data.clock[0]`.

    In lanes stand as many samples of one grasp, from here on.
    """
    for lane in range(WIDTH):
        t, end, at = (
            of_lane(begins, lane)[0],
            of_lane(data.clock, lane)[0],
            of_lane(data.place, lane),
        )
        if end > t:
            own, after, row = of_lane(piece, lane), of_lane(y, lane), int(at[0])
            while row < moments.shape[0] and of_lane(moments[row : row + 1], 0)[0] < end:
                now = moments[row]
                if now >= t and now < end:
                    fill_row((now - t) / (end - t), own, after, rows[lane * moments.shape[0] + row])
                row += 1
            at[0] = max(row - 1, 0)


def fill_row(x, piece, after, row):
    """See `interpolate_piece`, at as many places."""
    left = 1.0 - x
    bend = x * left
    for i in range(row.size):
        line = fused(x, after[i], left * piece[0, i])
        row[i] = fused(bend, fused(x, piece[2, i], piece[1, i]), line)


def pass_bound(data, clock, bounds, reached, failing):
    """Go on to the next bound, or end."""
    part = data.place[1] + (1.0 if reached else 0.0)
    data.place[1] = part
    ended = failing or part == bounds.size
    if reached:
        clock[1], clock[2] = 0.0, bounds[int(part)]
    if ended:  # on the spot, where nothing is taken
        clock[1], clock[2] = clock[3], clock[0] + 1.0
    if failing:
        data.failed[0] = 1.0
    data.alive[0] = 0.0 if ended else data.alive[0]
