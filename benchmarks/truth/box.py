"""A prism's section: a box with rounded edges, and the place of a rod that is nearest to it.

Against a flat side a rod's nearest place would jump from one of its ends to the other; candidates
are weighed by exp(-distance / 0.2 mm), so that a force wanders along the rod instead.
"""

from math import exp, sqrt

from benchmarks.truth._jit import compiled


@compiled
def outside(x, y, half_x, half_y):
    """Distance (m) from the box about the origin, negative inside, and its gradient."""
    side_x, side_y = (1.0 if x > 0.0 else -1.0), (1.0 if y > 0.0 else -1.0)
    u, v = x * side_x - half_x, y * side_y - half_y
    if u <= 0.0 or v <= 0.0:
        return (u, side_x, 0.0) if u > v else (v, 0.0, side_y)
    far = sqrt(u * u + v * v)
    return far, side_x * u / far, side_y * v / far


@compiled
def nearest(ax, ay, ex, ey, half_x, half_y):
    """Place along the rod from a by e (share of e), distance (m), unit normal into the box.

    a (m): from the box's centre. The least distance is at an end or over a corner.
    """
    length2 = ex * ex + ey * ey
    closest, weights, places = 1e9, 0.0, 0.0
    for k in range(6):
        place = 1.0 * k
        if k > 1:
            corner_x = half_x if k % 2 else -half_x
            corner_y = half_y if k > 3 else -half_y
            place = ((corner_x - ax) * ex + (corner_y - ay) * ey) / length2
            place = min(max(place, 0.0), 1.0)
        gap = outside(ax + place * ex, ay + place * ey, half_x, half_y)[0]
        if gap < closest:
            fade = exp((gap - closest) / 2e-4)
            closest, weights, places = gap, weights * fade, places * fade
        weight = exp((closest - gap) / 2e-4)
        weights, places = weights + weight, places + weight * place
    along = places / weights
    gap, away_x, away_y = outside(ax + along * ex, ay + along * ey, half_x, half_y)
    return along, gap, -away_x, -away_y
