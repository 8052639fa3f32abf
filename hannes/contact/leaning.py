"""Nearest place of a phalanx to a section that leans: turned, or cut askew out of a tilted object.

Such a section is an affine image of the object's own cross-section, a rectangle swept by a circle:
a parallelogram swept by an ellipse. All of it is in its support function, the distance of its
tangent with the outward normal n from its centre:

    h(n) = a |u| + b |v| + r sqrt(u^2 + v^2),   u = n . B e_1,  v = n . B e_2

with the frame B, core half sizes a, b and radius r [m]. Flat sides are arched by ARCH of their half
length, |u| -> sqrt(u^2 + ARCH^2), or the place of a link that lies flat would jump between its
ends. A point deeper inside than the section is round there has no one nearest place.
"""

import math

from hannes.core.kernels.jit import kernel

ARCH = 0.01
CLOSE = 1e-11  # rad
MOST = 40  # bisections alone would find a quarter turn to CLOSE


@kernel
def rounded(size, u, v, turned_u, turned_v, arch):
    """size sqrt(u^2 + v^2 + arch^2) with its first and second derivative by the normal's angle.

    `turned` are u and v of the normal turned by a quarter.
    """
    root = math.sqrt(u * u + v * v + arch * arch) + 1e-300
    slope = (u * turned_u + v * turned_v) / root
    bend = (turned_u * turned_u + turned_v * turned_v - u * u - v * v) / root
    return size * root, size * slope, size * (bend - slope * slope / root)


@kernel
def support(normal_x, normal_y, section):
    """h of the unit normal [m], and its first and second derivative by the normal's angle.

    `section`: a, b, r, then B by rows. The tangent touches at h n + h' n turned by a quarter.
    """
    half_x, half_y, radius, xx, xy, yx, yy = section
    u, v = xx * normal_x + yx * normal_y, xy * normal_x + yy * normal_y
    turned_u, turned_v = yx * normal_x - xx * normal_y, yy * normal_x - xy * normal_y
    h_1, d_1, s_1 = rounded(half_x, u, 0.0, turned_u, 0.0, ARCH)
    h_2, d_2, s_2 = rounded(half_y, v, 0.0, turned_v, 0.0, ARCH)
    h_3, d_3, s_3 = rounded(radius, u, v, turned_u, turned_v, 0.0)
    return h_1 + h_2 + h_3, d_1 + d_2 + d_3, s_1 + s_2 + s_3


@kernel
def nearest_place(start_x, start_y, along_x, along_y, length, section):
    """Place along a link [m], distance of the section from it [m], outward normal there.

    The link starts at `start` from the section's centre and goes along the unit vector `along`.
    Abreast of the section the normal is the link's own; where the section lies beyond an end, it
    has turned from there until that end lies farthest outside the tangent.
    """
    side = 1.0 if along_x * start_y - along_y * start_x >= 0.0 else -1.0
    normal_x, normal_y = -side * along_y, side * along_x
    height, slope, _ = support(normal_x, normal_y, section)
    # n turned by a quarter is -side times `along`
    place = -side * slope - (start_x * along_x + start_y * along_y)
    if 0.0 <= place <= length:
        return place, start_x * normal_x + start_y * normal_y - height, normal_x, normal_y
    place, ahead = (0.0, 1.0) if place < 0.0 else (length, -1.0)
    point_x, point_y = start_x + place * along_x, start_y + place * along_y
    low, high, angle = 0.0, 0.75 * math.pi, 0.25 * math.pi
    turn = -ahead * side  # sense in which the normal turns towards the rest of the link
    first_x, first_y = normal_x, normal_y
    for _ in range(MOST):
        cosine, sine = math.cos(angle), turn * math.sin(angle)
        normal_x, normal_y = first_x * cosine - first_y * sine, first_y * cosine + first_x * sine
        height, slope, bend = support(normal_x, normal_y, section)
        rise = turn * (point_y * normal_x - point_x * normal_y - slope)
        fall = point_x * normal_x + point_y * normal_y + bend
        if rise > 0.0:
            low = angle
        else:
            high = angle
        step = rise / fall if fall > 0.0 else math.inf
        if abs(step) < CLOSE or high - low < CLOSE:
            break
        angle = angle + step if low < angle + step < high else 0.5 * (low + high)
    return place, point_x * normal_x + point_y * normal_y - height, normal_x, normal_y
