"""What Python calls of an assembled model.

Text of the same kind as equations.py: compiled together with the equations, their solution and
the method, by whose names it goes. Each function becomes machine code when it is first called.
"""

from typing import Any

import numpy as np

from hannes.control.firmware_memory import READING_AGE
from hannes.core.kernels.pointers import address
from hannes.simulation.compiler.dense_jacobian import gather, linearise, slope
from hannes.simulation.rodas.linear_algebra import copy_to

# Filled in by assemble.py; the functions are the plant's, the method's and those of `OBSERVED`.
STATES, CHANNELS, OUTPUTS = 1, 1, 1
WORKSPACE: Any = None  # type of a record, see workspace.py
steps = np.full(31, 1e-3)
equations: Any = None
sample: Any = None
advance: Any = None
advance_tick: Any = None
sample_pieces: Any = None
each_grasp: Any = None  # see grasp_loop.py


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
    return step_on(
        room, p, reference, memory, y, rtol, atol, clock, counts, bounds, ends, pieces, work
    )


def step_on(
    room, p, reference, memory, y, rtol, atol, clock, counts, bounds, ends, pieces, work
):  # fmt: skip
    """The same in a workspace."""
    data = room[0]
    prepare(data, p, reference, memory)
    return advance(data, y, rtol, atol, clock, counts, bounds, ends, pieces, work)


def ticks_on(given, y, rtol, atol, clock, counts, bounds, ends, pieces, work):
    """Take steps up to the next tick, see rodas/whole_tick.py."""
    room, p, reference, memory = given
    return tick_on(
        room, p, reference, memory, y, rtol, atol, clock, counts, bounds, ends, pieces, work
    )


def tick_on(
    room, p, reference, memory, y, rtol, atol, clock, counts, bounds, ends, pieces, work
):  # fmt: skip
    """The same in a workspace."""
    data = room[0]
    prepare(data, p, reference, memory)
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
    wanted, room = np.any(columns < OUTPUTS), np.zeros(1, WORKSPACE)
    outputs, ages = np.zeros((times.size if wanted else 0, OUTPUTS)), np.zeros(periods.size)
    late = np.zeros((reading_ages(room, vectors, starts, reference, periods, ages), STATES))
    each_grasp(
        room, outputs, ages, late, np.zeros(1), vectors, starts, reference, bounds, periods, times,
        columns, needed, rtol, atol, stop, path, first, rows, memories, kept, counts,
    )  # fmt: skip


def reading_ages(room, vectors, starts, reference, periods, ages):
    """Fill ages (m,): how old the readings of the firmware's first tick are [s].

    Returns how many ticks they reach back, at most, and two more.
    """
    data, most = room[0], 1
    for k in range(periods.size):
        if periods[k] > 0.0:
            data.everything[:] = 0.0
            prepare(data, vectors[k], reference, data.memory[:0])
            sample(0.0, starts[k], data.dy, data.p, data.c, reference, data.memory, data.out)
            ages[k] = data.memory[READING_AGE]
            most = max(most, int(ages[k] / periods[k]) + 2)
    return most
