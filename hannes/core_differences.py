"""Derivatives of tensions and core by differences: of whatever effects are in their stages.

Text of the same kind as arrow.py, for sets of effects for which core_slopes.py does not hold.
"""

import numpy as np

from hannes.equations import (
    carts,
    control,
    drive,
    equations,
    excursions,
    gear,
    kinematics,
    leader,
    position_reference,
    sense,
)
from hannes.rodas.arrays import copy_to

# Filled in by structure.py: see arrow.py; here those of the hand without effects.
CORE = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10])
PART = np.array([0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2])  # who reads which of CORE: see structure.py
CART = np.array([0, 0, 1, 1, -1] + 7 * [-1] + [0, 1, 0, 1])  # whose row it is, of ROWS
TIMED = False  # whether other stages than the motor's read the time
APART = True  # whether only the carts, each for itself, read the wire taken up by their fingers
ALIKE = True  # whether it does not matter which of the two fingers takes it up
COUNT, ROWS = 11, 16
steps = np.full(31, 1e-3)


def core_columns(t, y, moved, rates, dy, drift, p, c, reference, hold, out, core, tensions):
    """Fill `core` and `drift`, df/dt; see workspace in arrow.py."""
    kinematics(y, p, c)
    base = difference_time(t, y, rates, dy, p, c, reference, hold, out, drift)
    copy_to(c.tendon_tension, tensions)
    for j in range(COUNT):
        difference_core(t, y, moved, rates, dy, p, c, reference, hold, out, base, j, core, tensions)
    for f in range(5):
        if not (APART and f in (2, 3)) and not (ALIKE and f in (1, 3)):
            difference_taking(t, y, rates, dy, p, c, out, base, f, core, tensions)


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


def difference_time(t, y, rates, dy, p, c, reference, hold, out, drift):
    """Fill df/dt; returns the torque constant."""
    later = t + 1e-7 * max(1.0, abs(t))
    if TIMED:
        equations(later, y, dy, p, c, reference, hold, out)
    else:
        copy_to(dy, rates)
        motor_stages(later, y, dy, p, c, reference, hold, out)
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
    if APART and f < 2:
        taken[f + 2] += nudge


def keep_taking(first, f, per, rates, dy, c, core, tensions):
    """Store the column of finger f, or those of the fingers that were moved along or are alike."""
    for g in range(5):
        core[first + f, g] = (c.tendon_tension[g] - tensions[g]) * per
    for i in range(COUNT):
        core[first + f, 5 + i] = (dy[CORE[i]] - rates[CORE[i]]) * per
    copy_to(c.tendon_tension, tensions)
    if APART and f < 2:
        for i in range(ROWS):
            core[first + f + 2, i] = core[first + f, i] if CART[i] == 1 else 0.0
            core[first + f, i] = core[first + f, i] if CART[i] == 0 else 0.0
            for finger in range(f, 4, 2):
                if ALIKE:
                    core[first + finger + 1, i] = core[first + finger, i]
