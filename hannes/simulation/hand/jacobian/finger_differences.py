"""Derivatives of the fingers' rates by differences: of whatever effects are in their stages.

Text of the same kind as arrowhead.py, for sets of effects for which finger_blocks.py does not hold.
All fingers are moved at once.
"""

import numpy as np

from hannes.simulation.hand.equations import contact, excursions, inertia, joints, kinematics, press
from hannes.simulation.rodas.linear_algebra import copy_to

# Filled in by sparsity.py: see arrowhead.py; here those of the hand without effects.
BORDER = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10])
OWN = np.array([[11 + k + 2 * f for f in range(5)] for k in (0, 1, 10, 11)])
SEEN = np.array([0])[:0]  # which of BORDER the finger stages read
HELD = True  # whether nothing but the flexor reads a tension in the fingers
SIZE, SEEING = 4, 0
steps = np.full(31, 1e-3)


def finger_columns(t, y, moved, rates, dy, p, c, out, tensions, blocks):
    """Fill `blocks`: see workspace in arrowhead.py."""
    difference_tensions(t, y, rates, dy, p, c, out, tensions, blocks)
    for n in range(SEEING):
        difference_seen(t, y, moved, rates, dy, p, c, out, n, blocks)
    for j in range(SIZE - 1, -1, -1):  # angles last: the links' directions hold till then
        difference_own(t, y, moved, rates, dy, p, c, out, j, blocks)


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
    """Rates of each finger by a border state that the finger stages read."""
    place = BORDER[SEEN[n]]
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
        if SEEING > 0:  # an object that border states move is not where it was
            finger_stages(t, moved, dy, p, c, out)
        else:
            moving_stages(t, moved, dy, p, c, out)
    for f in range(5):
        place = OWN[j, f]
        per = 1.0 / (moved[place] - y[place])
        for i in range(SIZE):
            blocks[i, j, f] = (dy[OWN[i, f]] - rates[OWN[i, f]]) * per
        moved[place] = y[place]
