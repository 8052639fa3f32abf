"""The hand's Jacobian and its solution: fingers meet in the carts, carts in the motor.

Text of the same kind as equations.py, compiled together with it. The rates of a finger depend
on its own states x_f and on its wire's tension T_f; tensions and the rates of all other states
(the border: motor, controller, carts) depend on the border and on the wire l_f that each finger
takes up, and its rate:

    dx_f/dt = F_f x_f + a_f T_f + C_f border,    (T, dborder/dt) = Z (border, l, dl/dt)

The border's blocks are differentiated from its stages' text (drivetrain_block.py). The fingers'
come in closed form (finger_blocks.py), or, where effects are in their stages that have none, from
differences of one state at a time with what they receive held (finger_differences.py). sparsity.py
decides which of the two, which states an effect adds to a finger or to the border, what it reads,
and when this shape does not hold. Arrays over fingers have the finger last, so that the five are
worked on at once.
"""

from typing import Any

import numpy as np

from hannes.core.kernels.jit import fused
from hannes.core.kernels.pointers import numbers_at, pointer, shaped, unknown
from hannes.simulation.hand.equations import equations
from hannes.simulation.rodas.linear_algebra import copy_to

# Filled in by sparsity.py; here those of the hand without effects.
BORDER = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10])  # places of the border's states
OWN = np.array([[11 + k + 2 * f for f in range(5)] for k in (0, 1, 10, 11)])  # of each finger's
SEEN = np.array([0])[:0]  # which of BORDER the finger stages read
SIZE, COUNT, SEEING, ROWS = 4, 11, 0, 16  # of OWN, BORDER, SEEN; tensions and border
PARAMETERS, STATES, CHANNELS, OUTPUTS = 1, 1, 1, 1
KINKS, ENTRIES = 30, 110
factor_fingers: Any = None  # these six written out by sparse_lu.py
solve_fingers: Any = None
gather_fingers: Any = None
scatter_fingers: Any = None
factor_border: Any = None
solve_border: Any = None
finger_columns: Any = None  # of finger_blocks.py or finger_differences.py
border_columns: Any = None  # written out by drivetrain_block.py

# What these functions pass around in the workspace, beside what any plant's do.
FIELDS = {
    "blocks": "(SIZE, SIZE + 1 + SEEING, 5)",  # by own states, tension, SEEN
    "border": "(COUNT + 10, ROWS)",  # columns by border states, wire taken up, its rate
    "tensions": "(5,)",
    "factors": "(SIZE, SIZE + 1 + SEEING, 5)",  # factors of the fingers, what acts solved
    "border_factors": "(ENTRIES,)",  # factors of tensions and border
    "couplings": "(2, 1 + SEEING, 5)",  # wire taken up for what acts, its rate
    "own": "(SIZE, 5)",  # own states of the fingers
    "excursion": "(5,)",  # wire taken up
    "excursion_rate": "(5,)",  # its rate
    "solved_tensions": "(5,)",
    "depths": "(KINKS,)",  # at the start of a step
    "depths_now": "(KINKS,)",  # at a stage
}


def slope(t, y, dy, data):
    """Fill dy with f(t, y)."""
    reference = numbers_at(data.reference[0], (data.reference[1], data.reference[2]))
    equations(t, y, dy, data.p, data.c, reference, data.memory, data.out)


def linearise(t, y, rates, drift, data):
    """Fill the blocks of df/dy, and df/dt; `rates` = f(t, y) was the last evaluation."""
    memory, out, dy = data.memory, data.out, shaped(pointer(data.dy), (unknown(STATES),))
    c = shaped(pointer(data.c), (CHANNELS,))
    reference = numbers_at(data.reference[0], (data.reference[1], data.reference[2]))
    tensions = data.tensions
    p = shaped(pointer(data.p), (unknown(PARAMETERS),))
    moved = shaped(pointer(data.moved), (unknown(STATES),))
    copy_to(moved, y)
    copy_to(tensions, c.tendon_tension)
    finger_columns(t, y, moved, rates, dy, p, c, out, tensions, data.blocks)
    border_columns(t, y, rates, dy, drift, p, c, reference, memory, out, data.border)


def difference_time(t, y, rates, dy, drift, p, c, reference, memory, out):
    """Fill df/dt where more than the border's rates changes with time."""
    later = t + 1e-7 * max(1.0, abs(t))
    equations(later, y, dy, p, c, reference, memory, out)
    for i in range(y.size):
        drift[i] = (dy[i] - rates[i]) / (later - t)


def decompose(shift, data):
    """Factor shift - df/dy: all fingers, then what is left of tensions and border."""
    p, factors, couplings = data.p, data.factors, data.couplings
    factor_fingers(shift, data.blocks, factors)
    for n in range(1 + SEEING):
        solve_fingers(factors, factors[:, SIZE + n])
        for kind in range(2):
            for f in range(5):
                mcp, pip = p.joint_moment_arm[2 * f], p.joint_moment_arm[2 * f + 1]
                couplings[kind, n, f] = mcp * factors[2 * kind, SIZE + n, f]
                couplings[kind, n, f] += pip * factors[2 * kind + 1, SIZE + n, f]
    factor_border(shift, data.border, couplings, data.border_factors)


def resolve(b, data):
    """Replace b by the solution x of (shift - df/dy) x = b."""
    p, factors, own, solved_tensions = data.p, data.factors, data.own, data.solved_tensions
    excursion, excursion_rate = data.excursion, data.excursion_rate
    gather_fingers(b, own)
    solve_fingers(factors, own)
    for f in range(5):
        mcp, pip = p.joint_moment_arm[2 * f], p.joint_moment_arm[2 * f + 1]
        excursion[f] = mcp * own[0, f] + pip * own[1, f]
        excursion_rate[f] = mcp * own[2, f] + pip * own[3, f]
    solve_border(b, excursion, excursion_rate, data.border, data.border_factors, solved_tensions)
    for i in range(SIZE):
        for n in range(SEEING):
            for f in range(5):
                own[i, f] = fused(factors[i, SIZE + 1 + n, f], b[BORDER[SEEN[n]]], own[i, f])
        for f in range(5):
            own[i, f] = fused(factors[i, SIZE, f], solved_tensions[f], own[i, f])
    scatter_fingers(own, b)


def mark(y, data):
    """Keep the depths of all one-sided contacts."""
    depths(y, data.p, data.c, data.depths)


def crossing(y, data):
    """How far on the way to y the first contact is made or lost; 1 where none is."""
    depths(y, data.p, data.c, data.depths_now)
    crossed = 0
    for k in range(KINKS):
        crossed += data.depths[k] * data.depths_now[k] < 0.0
    if crossed == 0:
        return 1.0
    first = 1.0
    for k in range(KINKS):
        before, after = data.depths[k], data.depths_now[k]
        if before * after < 0.0:
            first = min(first, before / (before - after))
    return first


def depths(y, p, c, found):
    """Depth of each phalanx in the object, of each joint in its stops."""
    present = p.object_present
    for k in range(10):
        found[k] = c.penetration[k] * present - (1.0 - present)
    for k in range(10):
        rest = p.rest[k] + p.joint_spring_preload[k] / p.joint_stop_stiffness[k]
        found[10 + k] = rest - y.joint_angle[k]
        found[20 + k] = y.joint_angle[k] - p.end[k]


def gather(data, columns):
    """Fill columns (n, n) with df/dy from the blocks that `linearise` left."""
    p, blocks, border = data.p, data.blocks, data.border
    columns[:] = 0.0
    for i in range(COUNT):
        for j in range(COUNT):
            columns[BORDER[i], BORDER[j]] = border[j, 5 + i]
    for f in range(5):
        for i in range(SIZE):
            for j in range(SIZE):
                columns[OWN[i, f], OWN[j, f]] = blocks[i, j, f]
            for n in range(SEEING):
                columns[OWN[i, f], BORDER[SEEN[n]]] = blocks[i, SIZE + 1 + n, f]
            for j in range(COUNT):
                columns[OWN[i, f], BORDER[j]] += blocks[i, SIZE, f] * border[j, f]
        for j in range(4):
            arm, column = p.joint_moment_arm[2 * f + j % 2], COUNT + 5 * (j // 2) + f
            for g in range(5):
                for i in range(SIZE):
                    columns[OWN[i, g], OWN[j, f]] += blocks[i, SIZE, g] * arm * border[column, g]
            for i in range(COUNT):
                columns[BORDER[i], OWN[j, f]] = arm * border[column, 5 + i]
