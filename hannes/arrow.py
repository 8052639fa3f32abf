"""The hand's Jacobian and its solution: fingers meet in the carts, carts in the motor.

Text of the same kind as equations.py, compiled together with it. The rates of a finger depend
on its own states and on its wire's tension; tensions and the rates of all other states (the
core: motor, controller, carts) depend on the core and on how much wire each finger takes up.
Stages are differenced one at a time with what they receive held, all fingers at once: whatever
effects are in the stages are in the differences. `structure.py` tells which states an effect
adds to a finger or to the core, and when this shape does not hold.

With x_f the states of a finger, z = (tensions, core), l_f = (excursion, its rate):

    (s - F_f) x_f = b_f + a_f T_f + C_f core,   z = Z (core, l) (+ b on the core's rows)
"""

import numpy as np

from hannes.equations import (
    carts,
    contact,
    control,
    drive,
    equations,
    excursions,
    gear,
    inertia,
    joints,
    kinematics,
    leader,
    position_reference,
    sense,
)
from hannes.rodas.arrays import copy_to

# Places of the core's states and of each finger's: two angles, two speeds, those of effects.
CORE = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10])
OWN = np.array([[11 + 2 * f, 12 + 2 * f, 21 + 2 * f, 22 + 2 * f] for f in range(5)])
SEEN = np.array([0])[:0]  # numbers of core states that finger stages read
PART = np.array([0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2])  # who reads a core state: see structure.py
steps = np.full(31, 1e-3)
CHANNELS, OUTPUTS = 1, 1


def motor_stages(t, y, dy, p, c, reference, hold, out):
    """From the reference to the winding; returns the torque constant [N m/A]."""
    target = position_reference(t, y, dy, p, c, reference, out)
    position, current = sense(t, y, dy, p, c, out)
    duty = control(t, y, dy, p, c, hold, target, position, current, out)
    return drive(t, y, dy, p, c, duty, out)


def wire_stages(t, y, dy, p, c, torque_constant, out):
    """Leader, gear and carts, given the excursions."""
    load = leader(t, y, dy, p, c, out)
    gear(t, y, dy, p, c, torque_constant, load, out)
    carts(t, y, dy, p, c, out)


def finger_stages(t, y, dy, p, c, out):
    """Joints, contact and inertia, given the tensions."""
    joints(t, y, dy, p, c, out)
    if p.object_present > 0.5:
        contact(t, y, dy, p, c, out)
    inertia(t, y, dy, p, c, out)


def linearise(t, y, rates, drift, data):
    """Fill the blocks of df/dy, and df/dt; `rates` = f(t, y) was the last evaluation."""
    p, reference, hold, c, out, dy, moved = data[0]
    blocks, core, tensions = data[1], data[2], data[3]
    copy_to(moved, y)
    copy_to(tensions, c.tendon_tension)
    difference_fingers(t, y, moved, rates, dy, p, c, out, tensions, blocks)
    copy_to(c.tendon_tension, tensions)
    kinematics(y, p, c)
    later = t + 1e-7 * max(1.0, abs(t))
    slope_later(later, y, dy, p, c, reference, hold, out)
    for i in range(y.size):
        drift[i] = (dy[i] - rates[i]) / (later - t)
    kinematics(y, p, c)
    difference_core(t, y, moved, rates, dy, p, c, reference, hold, out, tensions, core)


def slope_later(t, y, dy, p, c, reference, hold, out):
    """Rates at another time."""
    torque_constant = motor_stages(t, y, dy, p, c, reference, hold, out)
    wire_stages(t, y, dy, p, c, torque_constant, out)
    finger_stages(t, y, dy, p, c, out)


def difference_fingers(t, y, moved, rates, dy, p, c, out, tensions, blocks):
    """blocks[f, i, j]: rate i of finger f by its state j, by its tension, by core states SEEN."""
    size = OWN.shape[1]
    for f in range(5):
        c.tendon_tension[f] = tensions[f] + 1e-4 * max(1.0, abs(tensions[f]))
    finger_stages(t, moved, dy, p, c, out)
    for f in range(5):
        nudge = c.tendon_tension[f] - tensions[f]
        for i in range(size):
            blocks[f, i, size] = (dy[OWN[f, i]] - rates[OWN[f, i]]) / nudge
        c.tendon_tension[f] = tensions[f]
    for n in range(SEEN.size):
        place = CORE[SEEN[n]]
        moved[place] += 1e-7 * max(abs(y[place]), steps[place])
        finger_stages(t, moved, dy, p, c, out)
        for f in range(5):
            for i in range(size):
                change = dy[OWN[f, i]] - rates[OWN[f, i]]
                blocks[f, i, size + 1 + n] = change / (moved[place] - y[place])
        moved[place] = y[place]
    for j in range(size - 1, -1, -1):  # angles last: the directions of the links hold till then
        for f in range(5):
            place = OWN[f, j]
            moved[place] += 1e-7 * max(abs(y[place]), steps[place])
        if j < 2:
            kinematics(moved, p, c)
        else:
            excursions(moved, p, c)
        finger_stages(t, moved, dy, p, c, out)
        for f in range(5):
            place = OWN[f, j]
            for i in range(size):
                change = dy[OWN[f, i]] - rates[OWN[f, i]]
                blocks[f, i, j] = change / (moved[place] - y[place])
            moved[place] = y[place]


def difference_core(t, y, moved, rates, dy, p, c, reference, hold, out, tensions, core):
    """core[i, j]: tensions (i < 5) and core rates by core states, excursions, their rates."""
    count = CORE.size
    base = motor_stages(t, y, dy, p, c, reference, hold, out)
    for j in range(count):
        place = CORE[j]
        moved[place] += 1e-7 * max(abs(y[place]), steps[place])
        copy_to(dy, rates)
        torque_constant = base
        if PART[j] != 2:
            torque_constant = motor_stages(t, moved, dy, p, c, reference, hold, out)
        if PART[j] != 1:
            wire_stages(t, moved, dy, p, c, torque_constant, out)
        keep_core(moved[place] - y[place], j, rates, dy, c, tensions, core)
        copy_to(c.tendon_tension, tensions)
        moved[place] = y[place]
    for f in range(5):
        held = c.excursion[f]
        c.excursion[f] = held + 1e-9
        wire_stages(t, y, dy, p, c, base, out)
        keep_core(c.excursion[f] - held, count + f, rates, dy, c, tensions, core)
        c.excursion[f] = held
        held = c.excursion_rate[f]
        c.excursion_rate[f] = held + 1e-7
        wire_stages(t, y, dy, p, c, base, out)
        keep_core(c.excursion_rate[f] - held, count + 5 + f, rates, dy, c, tensions, core)
        c.excursion_rate[f] = held
    copy_to(c.tendon_tension, tensions)


def keep_core(nudge, column, rates, dy, c, tensions, core):
    """Store one column of differences."""
    for f in range(5):
        core[f, column] = (c.tendon_tension[f] - tensions[f]) / nudge
    for i in range(CORE.size):
        core[5 + i, column] = (dy[CORE[i]] - rates[CORE[i]]) / nudge


def decompose(shift, data):
    """Factor shift - df/dy: each finger, then what is left of tensions and core."""
    p = data[0][0]
    blocks, core, lifts, middle, takes = data[1], data[2], data[4], data[5], data[6]
    size, count = OWN.shape[1], CORE.size
    for f in range(5):
        factor_finger(shift, blocks[f], lifts[f])
        for n in range(1 + SEEN.size):
            for kind in range(2):
                takes[f, kind, n] = p.joint_moment_arm[0] * lifts[f, 2 * kind, size + n]
                takes[f, kind, n] += p.joint_moment_arm[1] * lifts[f, 2 * kind + 1, size + n]
    for i in range(5 + count):
        for f in range(5):
            pulled = core[i, count + f] * takes[f, 0, 0]
            middle[i, f] = -pulled - core[i, count + 5 + f] * takes[f, 1, 0]
        for j in range(count):
            middle[i, 5 + j] = -core[i, j]
        for n in range(SEEN.size):
            for f in range(5):
                middle[i, 5 + SEEN[n]] -= core[i, count + f] * takes[f, 0, 1 + n]
                middle[i, 5 + SEEN[n]] -= core[i, count + 5 + f] * takes[f, 1, 1 + n]
        middle[i, i] += 1.0 if i < 5 else shift
    eliminate(middle, 5 + count)


def factor_finger(shift, block, lift):
    """LU of shift - F in lift's first columns; the others solved: states by tension, by SEEN."""
    size = OWN.shape[1]
    for i in range(size):
        for j in range(size):
            lift[i, j] = -block[i, j]
        lift[i, i] += shift
        for n in range(1 + SEEN.size):
            lift[i, size + n] = block[i, size + n]
    eliminate(lift, size)
    for n in range(1 + SEEN.size):
        solve_triangles(lift, size, lift[:, size + n])


def eliminate(matrix, size):
    """LU in place without row exchanges, which the shift makes needless for short steps."""
    for k in range(size):
        pivot = 1.0 / matrix[k, k]
        for i in range(k + 1, size):
            if matrix[i, k] != 0.0:
                matrix[i, k] *= pivot
                for j in range(k + 1, size):
                    matrix[i, j] -= matrix[i, k] * matrix[k, j]


def solve_triangles(matrix, size, b):
    """Replace b by the solution."""
    for k in range(size):
        for i in range(k + 1, size):
            b[i] -= matrix[i, k] * b[k]
    for k in range(size - 1, -1, -1):
        b[k] /= matrix[k, k]
        for i in range(k):
            b[i] -= matrix[i, k] * b[k]


def resolve(b, data):
    """Replace b by the solution x of (shift - df/dy) x = b."""
    p = data[0][0]
    core, lifts, middle, z, own = data[2], data[4], data[5], data[7], data[8]
    size, count = OWN.shape[1], CORE.size
    for i in range(5 + count):
        z[i] = 0.0 if i < 5 else b[CORE[i - 5]]
    for f in range(5):
        for i in range(size):
            own[f, i] = b[OWN[f, i]]
        solve_triangles(lifts[f], size, own[f])
        taken = p.joint_moment_arm[0] * own[f, 0] + p.joint_moment_arm[1] * own[f, 1]
        rate = p.joint_moment_arm[0] * own[f, 2] + p.joint_moment_arm[1] * own[f, 3]
        for i in range(5 + count):
            z[i] += core[i, count + f] * taken + core[i, count + 5 + f] * rate
    solve_triangles(middle, 5 + count, z)
    for i in range(count):
        b[CORE[i]] = z[5 + i]
    for f in range(5):
        for i in range(size):
            x = own[f, i] + lifts[f, i, size] * z[f]
            for n in range(SEEN.size):
                x += lifts[f, i, size + 1 + n] * z[5 + SEEN[n]]
            b[OWN[f, i]] = x


def slope(t, y, dy, data):
    """Fill dy with f(t, y)."""
    p, reference, hold, c, out, _, _ = data[0]
    equations(t, y, dy, p, c, reference, hold, out)


def gather(data, columns):
    """Fill columns (n, n) with df/dy from the blocks that `linearise` left."""
    p, blocks, core = data[0][0], data[1], data[2]
    size, count = OWN.shape[1], CORE.size
    columns[:] = 0.0
    for i in range(count):
        for j in range(count):
            columns[CORE[i], CORE[j]] = core[5 + i, j]
    for f in range(5):
        for i in range(size):
            for j in range(size):
                columns[OWN[f, i], OWN[f, j]] = blocks[f, i, j]
            for n in range(SEEN.size):
                columns[OWN[f, i], CORE[SEEN[n]]] = blocks[f, i, size + 1 + n]
            for j in range(count):
                columns[OWN[f, i], CORE[j]] += blocks[f, i, size] * core[f, j]
        for j in range(4):
            arm, kind = p.joint_moment_arm[j % 2], j // 2
            for g in range(5):
                by_wire = arm * core[g, count + 5 * kind + f]
                for i in range(size):
                    columns[OWN[g, i], OWN[f, j]] += blocks[g, i, size] * by_wire
            for i in range(count):
                columns[CORE[i], OWN[f, j]] = arm * core[5 + i, count + 5 * kind + f]


def workspace(y, p, reference, hold):
    """Everything that these functions pass around."""
    size, count, seen = OWN.shape[1], CORE.size, SEEN.size
    n = y.size
    return (
        (p, reference, hold, np.zeros(CHANNELS), np.zeros(OUTPUTS), np.zeros(n), np.zeros(n)),
        np.zeros((5, size, size + 1 + seen)),  # blocks
        np.zeros((5 + count, count + 10)),  # core
        np.zeros(5),  # tensions
        np.zeros((5, size, size + 1 + seen)),  # lifts
        np.zeros((5 + count, 5 + count)),  # middle
        np.zeros((5, 2, 1 + seen)),  # takes
        np.zeros(5 + count),  # z
        np.zeros((5, size)),  # own
    )
