"""The hand's Jacobian and its solution: fingers meet in the carts, carts in the motor.

Text of the same kind as equations.py, compiled together with it. The rates of a finger depend
on its own states x_f and on its wire's tension T_f; tensions and the rates of all other states
(the core: motor, controller, carts) depend on the core and on the wire l_f that each finger
takes up, and its rate:

    dx_f/dt = F_f x_f + a_f T_f + C_f core,    (T, dcore/dt) = Z (core, l, dl/dt)

Stages are differenced one at a time with what they receive held, all fingers at once: whatever
effects are in the stages are in the differences. structure.py tells which states an effect adds
to a finger or to the core, what it reads, and when this shape does not hold. Arrays over fingers
have the finger last, so that the five are worked on at once.
"""

from typing import Any

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
    press,
    sense,
)
from hannes.rodas.arrays import copy_to

# Filled in by structure.py; here those of the hand without effects.
CORE = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10])  # places of the core's states
OWN = np.array([[11 + k + 2 * f for f in range(5)] for k in (0, 1, 10, 11)])  # of each finger's
SEEN = np.array([0])[:0]  # which of CORE the finger stages read
PART = np.array([0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2])  # who reads which of CORE: see structure.py
CART = np.array([0, 0, 1, 1, -1] + 7 * [-1] + [0, 1, 0, 1])  # whose row it is, of ROWS
TIMED = False  # whether other stages than the motor's read the time
HELD = True  # whether nothing but the flexor reads a tension in the fingers
PAIRED = True  # whether only the carts, each for itself, read the wire taken up by a pair
SIZE, COUNT, SEEING, ROWS = 4, 11, 0, 16  # of OWN, CORE, SEEN; tensions and core
CHANNELS, OUTPUTS = 1, 1
KINKS, ENTRIES = 30, 110
factor_rest: Any = None  # both written out by elimination.py
solve_rest: Any = None
steps = np.full(31, 1e-3)


def motor_stages(t, y, dy, p, c, reference, hold, out):
    """From the reference to the winding; returns the torque constant [N m/A]."""
    target = position_reference(t, y, dy, p, c, reference, out)
    position, current = sense(t, y, dy, p, c, hold, out)
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


def moving_stages(t, y, dy, p, c, out):
    """Finger stages where only the joints' speeds are others: contacts stay where they are."""
    joints(t, y, dy, p, c, out)
    if p.object_present > 0.5:
        press(t, y, dy, p, c, out)
    inertia(t, y, dy, p, c, out)


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
    difference_tensions(t, y, rates, dy, p, c, out, tensions, blocks)
    for n in range(SEEING):
        difference_seen(t, y, moved, rates, dy, p, c, out, n, blocks)
    for j in range(SIZE - 1, -1, -1):  # angles last: the links' directions hold till then
        difference_own(t, y, moved, rates, dy, p, c, out, j, blocks)
    kinematics(y, p, c)
    base = difference_time(t, y, rates, dy, p, c, reference, hold, out, drift)
    copy_to(c.tendon_tension, tensions)
    for j in range(COUNT):
        difference_core(t, y, moved, rates, dy, p, c, reference, hold, out, base, j, core, tensions)
    for f in range(5):
        if not PAIRED or f % 2 == 0:
            difference_taking(t, y, rates, dy, p, c, out, base, f, core, tensions)


def difference_tensions(t, y, rates, dy, p, c, out, tensions, blocks):
    """Rates of each finger by its tension; alone, a tension is as much torque on each joint."""
    nudge = 1e-3
    if HELD:
        for joint in range(10):
            c.joint_torque[joint] += nudge * p.joint_moment_arm[joint]
        copy_to(dy, rates)
        inertia(t, y, dy, p, c, out)
    else:
        for f in range(5):
            c.tendon_tension[f] = tensions[f] + nudge
        finger_stages(t, y, dy, p, c, out)
        copy_to(c.tendon_tension, tensions)
    for i in range(SIZE):
        for f in range(5):
            blocks[i, SIZE, f] = (dy[OWN[i, f]] - rates[OWN[i, f]]) / nudge


def difference_seen(t, y, moved, rates, dy, p, c, out, n, blocks):
    """Rates of each finger by a core state that the finger stages read."""
    place = CORE[SEEN[n]]
    moved[place] += 1e-7 * max(abs(y[place]), steps[place])
    finger_stages(t, moved, dy, p, c, out)
    for i in range(SIZE):
        for f in range(5):
            change = dy[OWN[i, f]] - rates[OWN[i, f]]
            blocks[i, SIZE + 1 + n, f] = change / (moved[place] - y[place])
    moved[place] = y[place]


def difference_own(t, y, moved, rates, dy, p, c, out, j, blocks):
    """Rates of each finger by its own state j: all fingers moved at once."""
    for f in range(5):
        place = OWN[j, f]
        moved[place] += 1e-7 * max(abs(y[place]), steps[place])
    if j < 2:
        kinematics(moved, p, c)
        finger_stages(t, moved, dy, p, c, out)
    else:
        excursions(moved, p, c)
        moving_stages(t, moved, dy, p, c, out)
    for f in range(5):
        place = OWN[j, f]
        per = 1.0 / (moved[place] - y[place])
        for i in range(SIZE):
            blocks[i, j, f] = (dy[OWN[i, f]] - rates[OWN[i, f]]) * per
        moved[place] = y[place]


def difference_time(t, y, rates, dy, p, c, reference, hold, out, drift):
    """Fill df/dt; returns the torque constant."""
    later = t + 1e-7 * max(1.0, abs(t))
    copy_to(dy, rates)
    torque_constant = motor_stages(later, y, dy, p, c, reference, hold, out)
    if TIMED:
        wire_stages(later, y, dy, p, c, torque_constant, out)
        finger_stages(later, y, dy, p, c, out)
    for i in range(y.size):
        drift[i] = (dy[i] - rates[i]) / (later - t)
    return motor_stages(t, y, dy, p, c, reference, hold, out)


def difference_core(t, y, moved, rates, dy, p, c, reference, hold, out, base, j, core, tensions):
    """Tensions and core rates by core state j."""
    place = CORE[j]
    moved[place] += 1e-7 * max(abs(y[place]), steps[place])
    copy_to(dy, rates)
    torque_constant = base
    if PART[j] != 2:
        torque_constant = motor_stages(t, moved, dy, p, c, reference, hold, out)
    if PART[j] != 1:
        wire_stages(t, moved, dy, p, c, torque_constant, out)
    per = 1.0 / (moved[place] - y[place])
    moved[place] = y[place]
    for f in range(5):
        core[j, f] = (c.tendon_tension[f] - tensions[f]) * per
        c.tendon_tension[f] = tensions[f]
    for i in range(COUNT):
        core[j, 5 + i] = (dy[CORE[i]] - rates[CORE[i]]) * per


def difference_taking(t, y, rates, dy, p, c, out, base, f, core, tensions):
    """Tensions and core rates by the wire that finger f takes up, then by its rate."""
    if PAIRED and f == 2:
        return  # along with finger 0
    copy_to(dy, rates)
    nudge_taking(c.excursion, f, 1e-9)
    wire_stages(t, y, dy, p, c, base, out)
    keep_taking(COUNT, f, 1e9, rates, dy, c, core, tensions)
    excursions(y, p, c)
    nudge_taking(c.excursion_rate, f, 1e-7)
    wire_stages(t, y, dy, p, c, base, out)
    keep_taking(COUNT + 5, f, 1e7, rates, dy, c, core, tensions)
    excursions(y, p, c)


def nudge_taking(taken, f, nudge):
    """Let finger f, or a finger of each cart, take up more."""
    taken[f] += nudge
    if PAIRED and f == 0:
        taken[2] += nudge


def keep_taking(first, f, per, rates, dy, c, core, tensions):
    """Store the column of finger f, or those of both carts' fingers."""
    for g in range(5):
        core[first + f, g] = (c.tendon_tension[g] - tensions[g]) * per
    for i in range(COUNT):
        core[first + f, 5 + i] = (dy[CORE[i]] - rates[CORE[i]]) * per
    copy_to(c.tendon_tension, tensions)
    if PAIRED and f == 0:
        for i in range(ROWS):
            core[first + 1, i] = core[first, i] if CART[i] == 0 else 0.0
            core[first + 2, i] = core[first, i] if CART[i] == 1 else 0.0
            core[first, i] = core[first + 1, i]
            core[first + 3, i] = core[first + 2, i]


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


def factor_fingers(shift, blocks, lifts):
    """LU of shift - F of all fingers in the first columns of lifts; what acts on them beside."""
    for i in range(SIZE):
        for j in range(SIZE):
            for f in range(5):
                lifts[i, j, f] = -blocks[i, j, f]
        for n in range(1 + SEEING):
            for f in range(5):
                lifts[i, SIZE + n, f] = blocks[i, SIZE + n, f]
        for f in range(5):
            lifts[i, i, f] += shift
    for k in range(SIZE):
        for f in range(5):
            lifts[k, k, f] = 1.0 / lifts[k, k, f]
        for i in range(k + 1, SIZE):
            for f in range(5):
                lifts[i, k, f] *= lifts[k, k, f]
            for j in range(k + 1, SIZE):
                for f in range(5):
                    lifts[i, j, f] -= lifts[i, k, f] * lifts[k, j, f]


def solve_fingers(lifts, b):
    """Replace b (states of a finger, fingers) by the solution of the factored fingers."""
    for i in range(1, SIZE):
        for k in range(i):
            for f in range(5):
                b[i, f] -= lifts[i, k, f] * b[k, f]
    for i in range(SIZE - 1, -1, -1):
        for k in range(i + 1, SIZE):
            for f in range(5):
                b[i, f] -= lifts[i, k, f] * b[k, f]
        for f in range(5):
            b[i, f] *= lifts[i, i, f]


def resolve(b, data):
    """Replace b by the solution x of (shift - df/dy) x = b."""
    p = data[0][0]
    lifts, own, taken, rate, pulls = data[4], data[7], data[8], data[9], data[10]
    for i in range(SIZE):
        for f in range(5):
            own[i, f] = b[OWN[i, f]]
    solve_fingers(lifts, own)
    for f in range(5):
        taken[f] = p.joint_moment_arm[0] * own[0, f] + p.joint_moment_arm[1] * own[1, f]
        rate[f] = p.joint_moment_arm[0] * own[2, f] + p.joint_moment_arm[1] * own[3, f]
    solve_rest(b, taken, rate, data[2], data[5], pulls)
    for i in range(SIZE):
        for n in range(SEEING):
            for f in range(5):
                own[i, f] += lifts[i, SIZE + 1 + n, f] * b[CORE[SEEN[n]]]
        for f in range(5):
            b[OWN[i, f]] = own[i, f] + lifts[i, SIZE, f] * pulls[f]


def mark(y, data):
    """Keep the depths of all one-sided contacts."""
    depths(y, data[0][0], data[0][3], data[11])


def crossing(y, data):
    """How far on the way to y the first contact is made or lost; 1 where none is."""
    depths(y, data[0][0], data[0][3], data[12])
    first = 1.0
    for k in range(KINKS):
        before, after = data[11][k], data[12][k]
        if before * after < 0.0:
            first = min(first, before / (before - after))
    return first


def depths(y, p, c, found):
    """Depth of each phalanx in the object, of each joint in its stops."""
    for k in range(10):
        found[k] = c.penetration[k] if p.object_present > 0.5 else -1.0
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
