"""What Python calls of an assembled model, and the loop that runs whole grasps in one call.

Text of the same kind as equations.py: compiled together with the equations, their solution and
the method, by whose names it goes. Each function becomes machine code when it is first called.
"""

from typing import Any

import numpy as np

from hannes.control.firmware_memory import READING_AGE
from hannes.core.kernels.pointers import address, pointer, shaped, unknown
from hannes.simulation.compiler.dense_jacobian import gather, linearise, slope
from hannes.simulation.compiler.workspace import RUN
from hannes.simulation.rodas.linear_algebra import copy_to
from hannes.simulation.rodas.step import NOT_FINITE, TOO_MANY, WORK

# Filled in by assemble.py; the functions are the plant's, the method's and those of `OBSERVED`.
STATES, CHANNELS, OUTPUTS = 1, 1, 1
WORKSPACE: Any = None  # type of a record, see workspace.py
steps = np.full(31, 1e-3)
equations: Any = None
sample: Any = None
advance: Any = None
advance_tick: Any = None
sample_pieces: Any = None
fill_outputs: Any = None

LONGEST = 0.03  # s, of a step: a longer one may miss a contact that comes and goes
MOST = 1_000_000  # steps of one grasp: seconds, where an ordinary one takes a few hundred
PATH = 20_000  # steps of a grasp that others follow, at most
APART = 20  # times as many steps: a grasp that needs them is not near the one it follows
ASTRAY = -4  # failure of one that does, beside those of rodas/step.py


def rates(t, y, p, reference, memory):
    """dy/dt, shape (states,)."""
    dy, y = np.zeros(STATES), np.ascontiguousarray(y)
    equations(t, y, dy, p, np.zeros(CHANNELS), reference, memory, np.zeros(OUTPUTS))
    return dy


def jacobian(t, y, p, reference, memory):
    """df/dy as the integrator has it, shape (states, states)."""
    columns, y = np.zeros((STATES, STATES)), np.ascontiguousarray(y)
    fill_jacobian(np.zeros(1, WORKSPACE), t, y, p, reference, memory, columns)
    return columns


def fill_jacobian(room, t, y, p, reference, memory, columns):
    """The same into `columns`."""
    data = room[0]
    prepare(data, p, reference, memory)
    slope(t, y, data.work[0], data)
    linearise(t, y, data.work[0], data.work[1], data)
    gather(data, columns)


def prepare(data, p, reference, memory):
    """Give an empty workspace parameters, reference and numbers that firmware keeps."""
    data.reference[0] = address(reference)
    data.reference[1], data.reference[2] = reference.shape
    copy_to(data.p, p)
    for i in range(memory.size):
        data.memory[i] = memory[i]


def differences(t, y, p, reference, memory):
    """df/dy by forward differences, one column a state."""
    c, out, moved = np.zeros(CHANNELS), np.zeros(OUTPUTS), y.copy()
    base, dy, columns = np.zeros(STATES), np.zeros(STATES), np.zeros((STATES, STATES))
    equations(t, moved, base, p, c, reference, memory, out)
    for j in range(STATES):
        moved[j] += 1e-7 * max(abs(y[j]), steps[j])
        equations(t, moved, dy, p, c, reference, memory, out)
        columns[:, j] = (dy - base) / (moved[j] - y[j])
        moved[j] = y[j]
    return columns


def tick(t, y, p, reference, memory):
    """One tick of the sampled controller, upon `memory`."""
    y = np.ascontiguousarray(y)
    sample(t, y, np.zeros(STATES), p, np.zeros(CHANNELS), reference, memory, np.zeros(OUTPUTS))


def steps_on(given, y, rtol, atol, clock, counts, bounds, ends, pieces, work):
    """Take steps, see rodas/step.py. given: workspace, parameters, reference, memory."""
    room, p, reference, memory = given
    known = p, reference, memory
    return step_on(room, known, y, rtol, atol, clock, counts, bounds, ends, pieces, work)


def step_on(room, given, y, rtol, atol, clock, counts, bounds, ends, pieces, work):
    """The same in a workspace."""
    data = room[0]
    prepare(data, given[0], given[1], given[2])
    return advance(data, y, rtol, atol, clock, counts, bounds, ends, pieces, work)


def ticks_on(given, y, rtol, atol, clock, counts, bounds, ends, pieces, work):
    """Take steps up to the next tick, see rodas/whole_tick.py."""
    room, p, reference, memory = given
    known = p, reference, memory
    return tick_on(room, known, y, rtol, atol, clock, counts, bounds, ends, pieces, work)


def tick_on(room, given, y, rtol, atol, clock, counts, bounds, ends, pieces, work):
    """The same in a workspace."""
    data = room[0]
    prepare(data, given[0], given[1], given[2])
    return advance_tick(data, y, rtol, atol, clock, counts, bounds, ends, pieces, work)


def look_up(times, ends, pieces, rows):
    """Sample the dense output."""
    sample_pieces(times, ends, pieces, rows)


def grasps(
    vectors, starts, reference, bounds, periods, times, columns, needed,
    rtol, atol, stop, path, first, rows, memories, kept, counts,
):  # fmt: skip
    """Run one grasp for each row of `vectors` (m, parameters), from `starts` (m, states).

    path (n,): where it has room, all go by the steps of the first one (with the continuous
    controller), cut where a grasp needs shorter ones: what differs between them is then nearly as
    smooth as it is without steps. Where the first one fails, or takes too many, each takes its own.
    It holds how many steps there are, and their ends; where it does so already the first one
    follows too, after `first` of them. `starts` become the states at the end.

    bounds (b,) [s]: ends of the smooth parts, the last one that of the grasp; periods (m,) [s]
    of the sampled controller, 0 for the continuous one. Samples at `times` (n,) go into `rows`
    (n, states) and `memories` (n, kept numbers), which the next grasp overwrites, and the `columns`
    (w,) among outputs, then states, into `kept` (m, w, n), outputs by the statements that are
    `needed` (see output_slice.py). counts (m, 6): evaluations, Jacobians,
    factorings, rejected steps, failure or 0, samples before it. Ends early where stop[0].
    """
    wanted = False
    for column in columns:
        wanted |= column < OUTPUTS
    outputs = np.zeros((times.size if wanted else 0, OUTPUTS))
    none = np.zeros(1)
    room, prompt = np.zeros(1, WORKSPACE), np.zeros((1, STATES))
    followed = path[0] > 0.0
    for k in range(vectors.shape[0]):
        if stop[0]:
            return
        own, way, seen = counts[k], path if k == 0 or path[0] > 0.0 else none, prompt
        if periods[k] > 0.0:
            age = reading_age(room, starts[k], vectors[k], reference)
            if age > 0.0:
                seen = np.ones((int(age / periods[k]) + 2, 1)) * starts[k]
        reached = grasp(
            room, starts[k], vectors[k], reference, bounds, periods[k], times, seen,
            rtol, atol, stop, way, first, rows, memories, own,
        )  # fmt: skip
        counts[k, 5] = finite(rows, reached)
        if counts[k, 5] < reached:
            counts[k, 4] = NOT_FINITE
            path[0] = path[0] if k > 0 or followed else 0.0
        asked, filled = (columns, needed), counts[k, 5]
        keep(vectors[k], reference, times, asked, rows, memories, outputs, kept[k], filled)


def reading_age(room, y, p, reference):
    """How old the readings of the firmware's first tick are [s]."""
    data = room[0]
    data.everything[:] = 0.0
    prepare(data, p, reference, data.memory[:0])
    sample(0.0, y, data.dy, data.p, data.c, reference, data.memory, data.out)
    return data.memory[READING_AGE]


def grasp(
    room, y, p, reference, bounds, period, times, seen,
    rtol, atol, stop, path, first, rows, memories, counts,
):  # fmt: skip
    """Smooth part after smooth part, or tick after tick; returns how many samples were reached.

    seen (m, states): what the firmware reads at ticks to come, where its readings are old.
    path (n,): how many steps another grasp took, and their ends, which are followed; where none
    is known the grasp's own are noted there, as far as there is room. `first` were taken before.
    """
    data = room[0]
    data.everything[:] = 0.0
    prepare(data, p, reference, data.memory[:0])
    memory, ends, clock, ahead = data.memory, data.ends, data.clock, data.ahead
    work = shaped(pointer(data.work), (WORK, unknown(STATES)))
    pieces = shaped(pointer(data.pieces), (RUN + 1, 3, unknown(STATES)))
    last, end, filled = bounds[bounds.size - 1], 0.0, 0
    clock[2], clock[3], clock[4], clock[0] = bounds[0], LONGEST, 1.0, path[first] * (first > 0)
    data.turn[:] = 1.0
    place, follow, goal = first, path[0] > 0.0 and period == 0.0, bounds
    parts = 1 if period == 0.0 else int(np.ceil(last / period - 1e-9))
    for part in range(parts):
        start, end = end, last if period == 0.0 else min((part + 1) * period, last)
        if period > 0.0:
            goal, ahead[0] = ahead[:], end
            clock[0], clock[1], clock[2] = start, end - start, end
            then = seen[part % seen.shape[0]] if memory[READING_AGE] > 0.0 else y
            sample(start, then, data.dy, data.p, data.c, reference, memory, data.out)
        while clock[0] != end:
            if follow:
                goal = ahead[:]
                if place == 0 or clock[0] == path[place]:
                    place += 1
                    ahead[0] = path[place]
                    clock[1], clock[2] = ahead[0] - clock[0], ahead[0]
            taken = go_on(period, data, y, rtol, atol, clock, counts, goal, ends, pieces, work)
            if not follow:
                place = noted(ends, taken, path, place)
            if memory[READING_AGE] > 0.0:
                read_ahead(memory[READING_AGE], period, ends[: taken + 1], pieces, data.turn, seen)
            until = ends[taken] if period == 0.0 else ends[taken] * (1.0 - 1e-12)
            filled = take_samples(times, filled, until, ends, taken, pieces, rows, memories, memory)
            judge(counts, path, follow)
            if counts[4] != 0 or stop[0]:
                return filled
    for row in range(filled, times.size):
        copy_to(rows[row], y)
        copy_to(memories[row], memory)
    path[0] = path[0] if follow else place * (place < path.size)
    return times.size


def go_on(period, data, y, rtol, atol, clock, counts, bounds, ends, pieces, work):
    """Take steps, those of a sampled controller up to its next tick; returns how many."""
    if period > 0.0:
        return advance_tick(data, y, rtol, atol, clock, counts, bounds, ends, pieces, work)
    return advance(data, y, rtol, atol, clock, counts, bounds, ends, pieces, work)


def take_samples(times, first, before, ends, taken, pieces, rows, memories, memory):
    """Sample the dense output of `taken` steps from sample `first` up to the time `before`.

    Returns how many samples there are now.
    """
    filled = first
    while filled < times.size and times[filled] < before:
        filled += 1
    sample_pieces(times[first:filled], ends[: taken + 1], pieces, rows[first:filled])
    for row in range(first, filled):
        copy_to(memories[row], memory)
    return filled


def judge(counts, path, follow):
    """Note a failure of a grasp that takes too many steps, or strays from the one it follows."""
    if counts[4] == 0 and counts[1] > MOST:
        counts[4] = TOO_MANY
    if counts[4] == 0 and follow and counts[1] + counts[3] > APART * path[0]:
        counts[4] = ASTRAY


def noted(ends, taken, path, place):
    """Note the ends of steps taken after the first `place`; returns how many there are now."""
    for k in range(taken):
        place += 1
        if place < path.size:
            path[place] = ends[k + 1]
    return place


def read_ahead(age, period, ends, pieces, turn, seen):
    """Keep what the firmware reads `age` later, at ticks to come: a row of `seen` for each.

    turn: moment of a reading [s], tick that is next.
    """
    while turn[1] * period - age <= ends[ends.size - 1]:
        turn[0] = turn[1] * period - age
        row = int(turn[1]) % seen.shape[0]
        if turn[0] > 0.0:
            sample_pieces(turn[:1], ends, pieces, seen[row : row + 1])
        turn[1] += 1.0


def finite(rows, filled):
    """How many of the first `filled` rows come before one that is not finite."""
    for row in range(filled):
        bad = 0
        for i in range(rows.shape[1]):
            bad += not abs(rows[row, i]) < np.inf
        if bad > 0:
            return row
    return filled


def keep(p, reference, times, asked, rows, memories, outputs, kept, filled):
    """Fill `kept` (w, n) with what was asked for."""
    columns, needed = asked
    if outputs.size > 0:
        fill_outputs(times[:filled], rows, p, reference, memories, needed, outputs)
    for w in range(columns.size):
        column = columns[w]
        for row in range(filled):
            kept[w, row] = outputs[row, column] if column < OUTPUTS else rows[row, column - OUTPUTS]
