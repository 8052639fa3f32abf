"""The loop that runs whole grasps in one call; text of the same kind as entry_points.py."""

from typing import Any

import numpy as np

from hannes.control.firmware_memory import READING_AGE
from hannes.core.kernels.pointers import pointer, shaped, unknown
from hannes.simulation.compiler.entry_points import prepare
from hannes.simulation.compiler.workspace import RUN
from hannes.simulation.rodas.linear_algebra import copy_to
from hannes.simulation.rodas.step import NOT_FINITE, TOO_MANY, WORK

# Filled in by assemble.py; the functions are the plant's, the method's and those of `OBSERVED`.
STATES, OUTPUTS = 1, 1
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


def each_grasp(
    room, outputs, ages, late, none, vectors, starts, reference, bounds, periods, times, columns,
    needed, rtol, atol, stop, path, first, rows, memories, kept, counts,
):  # fmt: skip
    """`grasps` in room that is given: `outputs`, states `late` that are still to be read."""
    followed = path[0] > 0.0
    for k in range(vectors.shape[0]):
        if stop[0]:
            return
        own, way, reach = counts[k], path if k == 0 or path[0] > 0.0 else none, 1
        if ages[k] > 0.0:
            reach = int(ages[k] / periods[k]) + 2
            for row in range(reach):
                copy_to(late[row], starts[k])
        reached = grasp(
            room, starts[k], vectors[k], reference, bounds, periods[k], times, late[:reach],
            rtol, atol, stop, way, first, rows, memories, own,
        )  # fmt: skip
        counts[k, 5] = finite(rows, reached)
        if counts[k, 5] < reached:
            counts[k, 4] = NOT_FINITE
            path[0] = path[0] if k > 0 or followed else 0.0
        asked, filled = (columns, needed), counts[k, 5]
        keep(vectors[k], reference, times, asked, rows, memories, outputs, kept[k], filled)


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
    memory, clock, ahead = data.memory, data.clock, shaped(pointer(data.ahead), (unknown(1),))
    ends = shaped(pointer(data.ends), (unknown(RUN + 1),))
    work = shaped(pointer(data.work), (WORK, unknown(STATES)))
    pieces = shaped(pointer(data.pieces), (RUN + 1, 3, unknown(STATES)))
    last, end, filled = bounds[bounds.size - 1], 0.0, 0
    clock[2], clock[3], clock[4], clock[0] = bounds[0], LONGEST, 1.0, path[first] * (first > 0)
    data.turn[:] = 1.0
    place, follow = first, path[0] > 0.0 and period == 0.0
    parts = 1 if period == 0.0 else int(np.ceil(last / period - 1e-9))
    for part in range(parts):
        start, end = end, last if period == 0.0 else min((part + 1) * period, last)
        if period > 0.0:
            ahead[0], clock[0], clock[1], clock[2] = end, start, end - start, end
            then = seen[part % seen.shape[0]] if memory[READING_AGE] > 0.0 else y
            sample(start, then, data.dy, data.p, data.c, reference, memory, data.out)
        while clock[0] != end:
            if follow:
                if place == 0 or clock[0] == path[place]:
                    place += 1
                    ahead[0] = path[place]
                    clock[1], clock[2] = ahead[0] - clock[0], ahead[0]
            goal = ahead if follow or period > 0.0 else bounds
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
