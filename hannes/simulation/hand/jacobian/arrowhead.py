"""The hand's Jacobian and its solution: fingers meet in the carts, carts in the motor.

Text of the same kind as equations.py, compiled together with it. The rates of a finger depend
on its own states x_f and on its wire's tension T_f; tensions and the rates of all other states
(the core: motor, controller, carts) depend on the core and on the wire l_f that each finger
takes up, and its rate:

    dx_f/dt = F_f x_f + a_f T_f + C_f core,    (T, dcore/dt) = Z (core, l, dl/dt)

The core's blocks are derived from its stages' text (drivetrain_block.py), the fingers' come in
closed form (finger_blocks.py), or, where effects are in their stages that have none, from
differences of one state at a time with what they receive held (finger_differences.py). sparsity.py
decides which of the two, which states an effect adds to a finger or to the core, what it reads, and
when this shape does not hold. Arrays over fingers have the finger last, so that the five are worked
on at once.
"""

from typing import Any

import numpy as np

from hannes.core.kernels.jit import fused
from hannes.simulation.hand.equations import equations
from hannes.simulation.rodas.linear_algebra import copy_to

# Filled in by sparsity.py; here those of the hand without effects.
CORE = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10])  # places of the core's states
OWN = np.array([[11 + k + 2 * f for f in range(5)] for k in (0, 1, 10, 11)])  # of each finger's
SEEN = np.array([0])[:0]  # which of CORE the finger stages read
SIZE, COUNT, SEEING, ROWS = 4, 11, 0, 16  # of OWN, CORE, SEEN; tensions and core
CHANNELS, OUTPUTS = 1, 1
KINKS, ENTRIES = 30, 110
factor_fingers: Any = None  # these six written out by sparse_lu.py
solve_fingers: Any = None
take_fingers: Any = None
give_fingers: Any = None
factor_rest: Any = None
solve_rest: Any = None
finger_columns: Any = None  # of finger_blocks.py or finger_differences.py
core_columns: Any = None  # written out by drivetrain_block.py


def slope(t, y, dy, data):
    """Fill dy with f(t, y)."""
    p, reference, hold, c, out, _, _ = data[0]
    equations(t, y, dy, p, c, reference, hold, out)


def linearise(t, y, rates, drift, data):
    """Fill the blocks of df/dy, and df/dt; `rates` = f(t, y) was the last evaluation."""
    p, reference, hold, c, out, dy, moved = data[0]
    blocks, core, tensions = data[1], data[2], data[3]
    copy_to(moved, y)
    copy_to(tensions, c.tendon_tension)
    finger_columns(t, y, moved, rates, dy, p, c, out, tensions, blocks)
    core_columns(t, y, rates, dy, drift, p, c, reference, hold, out, core)


def difference_time(t, y, rates, dy, drift, p, c, reference, hold, out):
    """Fill df/dt where more than the core's rates changes with time."""
    later = t + 1e-7 * max(1.0, abs(t))
    equations(later, y, dy, p, c, reference, hold, out)
    for i in range(y.size):
        drift[i] = (dy[i] - rates[i]) / (later - t)


def decompose(shift, data):
    """Factor shift - df/dy: all fingers, then what is left of tensions and core."""
    p = data[0][0]
    blocks, core, lifts, takes = data[1], data[2], data[4], data[6]
    factor_fingers(shift, blocks, lifts)
    for n in range(1 + SEEING):
        solve_fingers(lifts, lifts[:, SIZE + n])
        for kind in range(2):
            for f in range(5):
                takes[kind, n, f] = p.joint_moment_arm[0] * lifts[2 * kind, SIZE + n, f]
                takes[kind, n, f] += p.joint_moment_arm[1] * lifts[2 * kind + 1, SIZE + n, f]
    factor_rest(shift, core, takes, data[5])


def resolve(b, data):
    """Replace b by the solution x of (shift - df/dy) x = b."""
    p = data[0][0]
    lifts, own, taken, rate, pulls = data[4], data[7], data[8], data[9], data[10]
    take_fingers(b, own)
    solve_fingers(lifts, own)
    for f in range(5):
        taken[f] = p.joint_moment_arm[0] * own[0, f] + p.joint_moment_arm[1] * own[1, f]
        rate[f] = p.joint_moment_arm[0] * own[2, f] + p.joint_moment_arm[1] * own[3, f]
    solve_rest(b, taken, rate, data[2], data[5], pulls)
    for i in range(SIZE):
        for n in range(SEEING):
            for f in range(5):
                own[i, f] = fused(lifts[i, SIZE + 1 + n, f], b[CORE[SEEN[n]]], own[i, f])
        for f in range(5):
            own[i, f] = fused(lifts[i, SIZE, f], pulls[f], own[i, f])
    give_fingers(own, b)


def mark(y, data):
    """Keep the depths of all one-sided contacts."""
    depths(y, data[0][0], data[0][3], data[11])


def crossing(y, data):
    """How far on the way to y the first contact is made or lost; 1 where none is."""
    depths(y, data[0][0], data[0][3], data[12])
    crossed = 0
    for k in range(data[11].size):
        crossed += data[11][k] * data[12][k] < 0.0
    if crossed == 0:
        return 1.0
    first = 1.0
    for k in range(KINKS):
        before, after = data[11][k], data[12][k]
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
    p, blocks, core = data[0][0], data[1], data[2]
    columns[:] = 0.0
    for i in range(COUNT):
        for j in range(COUNT):
            columns[CORE[i], CORE[j]] = core[j, 5 + i]
    for f in range(5):
        for i in range(SIZE):
            for j in range(SIZE):
                columns[OWN[i, f], OWN[j, f]] = blocks[i, j, f]
            for n in range(SEEING):
                columns[OWN[i, f], CORE[SEEN[n]]] = blocks[i, SIZE + 1 + n, f]
            for j in range(COUNT):
                columns[OWN[i, f], CORE[j]] += blocks[i, SIZE, f] * core[j, f]
        for j in range(4):
            arm, column = p.joint_moment_arm[j % 2], COUNT + 5 * (j // 2) + f
            for g in range(5):
                for i in range(SIZE):
                    columns[OWN[i, g], OWN[j, f]] += blocks[i, SIZE, g] * arm * core[column, g]
            for i in range(COUNT):
                columns[CORE[i], OWN[j, f]] = arm * core[column, 5 + i]


def workspace(y, p, reference, hold):
    """Everything that these functions pass around."""
    n = y.size
    return (
        (p, reference, hold, np.zeros(CHANNELS), np.zeros(OUTPUTS), np.zeros(n), np.zeros(n)),
        np.zeros((SIZE, SIZE + 1 + SEEING, 5)),  # blocks: by own states, tension, SEEN
        np.zeros((COUNT + 10, ROWS)),  # core: columns by core states, wire taken up, its rate
        np.zeros(5),  # tensions
        np.zeros((SIZE, SIZE + 1 + SEEING, 5)),  # lifts: factors of the fingers, what acts solved
        np.zeros(ENTRIES),  # factors of the rest
        np.zeros((2, 1 + SEEING, 5)),  # takes: wire taken up for what acts, its rate
        np.zeros((SIZE, 5)),  # own states of the fingers
        np.zeros(5),  # wire taken up
        np.zeros(5),  # its rate
        np.zeros(5),  # tensions that solve
        np.zeros(KINKS),  # depths at the start of a step
        np.zeros(KINKS),  # depths at a stage
    )
