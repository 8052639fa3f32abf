"""Distance from a phalanx (a capsule's axis) to the object's section in the finger's plane.

A section is a rounded rectangle: a core of half sizes (a, b) about its centre, swept by a
radius. A circle is a rounded rectangle whose core is a point.
"""

import math

from hannes.core.kernels.jit import kernel


@kernel
def signed_distance(x, y, half_x, half_y):
    """Distance [m] from a point to the core rectangle, negative inside; with its gradient.

    Far inside, where two sides are about as near, the normal turns from one to the other: with
    depths u, v below them the distance is -(u^-8 + v^-8)^(-1/8) in place of -min(u, v), or soft
    prisms would be left chattering between two directions of force.
    """
    over_x, over_y = abs(x) - half_x, abs(y) - half_y
    sign_x = 1.0 if x >= 0.0 else -1.0
    sign_y = 1.0 if y >= 0.0 else -1.0
    if over_x > 0.0 and over_y > 0.0:
        distance = math.sqrt(over_x * over_x + over_y * over_y)
        per = 1.0 / distance
        return distance, sign_x * over_x * per, sign_y * over_y * per
    if over_x >= 0.0:
        return over_x, sign_x, 0.0
    if over_y >= 0.0:
        return over_y, 0.0, sign_y
    ratio = max(over_x, over_y) / min(over_x, over_y)  # of the lesser depth to the other
    eighth = (ratio * ratio * ratio * ratio) ** 2
    root = math.sqrt(math.sqrt(math.sqrt(1.0 + eighth)))
    near = 1.0 / (root * (1.0 + eighth))
    far = near * eighth * ratio
    if over_x > over_y:
        return over_x / root, sign_x * near, sign_y * far
    return over_y / root, sign_x * far, sign_y * near


@kernel
def along_link(x, y, start_x, start_y, direction_x, direction_y, length):
    """Place along the link [m] nearest to a point, kept on the link."""
    place = (x - start_x) * direction_x + (y - start_y) * direction_y
    return min(max(place, 0.0), length)


@kernel
def contact_place(start_x, start_y, direction_x, direction_y, length, half_x, half_y):
    """Place along the link [m] of nearest approach to a section centred at the origin.

    Against a flat side the nearest place jumps from one end of a link to the other; it is
    blended over `blend` = 0.2 mm of distance so that the force moves along without a jump.
    """
    if half_x == 0.0 and half_y == 0.0:
        return along_link(0.0, 0.0, start_x, start_y, direction_x, direction_y, length)
    blend = 2e-4
    least, total, weighted = 1e9, 0.0, 0.0
    for candidate in range(6):
        place = length * candidate
        if candidate >= 2:
            corner_x = half_x if candidate < 4 else -half_x
            corner_y = half_y if candidate % 2 == 0 else -half_y
            place = along_link(
                corner_x, corner_y, start_x, start_y, direction_x, direction_y, length
            )
        distance = signed_distance(
            start_x + place * direction_x, start_y + place * direction_y, half_x, half_y
        )[0]
        if distance < least:
            scale = math.exp((distance - least) / blend)
            least, total, weighted = distance, total * scale, weighted * scale
        weight = math.exp((least - distance) / blend)
        total += weight
        weighted += weight * place
    return weighted / total
