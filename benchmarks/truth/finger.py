"""One finger in natural coordinates: the planar positions of its PIP joint P and its tip T.

A slender uniform rod between A and B has the constant mass matrix m/6 [2 1; 1 2] (per axis) on
(A, B), and any point fixed in it is a constant combination of A and B: forces go to the joints'
positions, and the sum is projected on the two joint angles by X' = R(q) q' (de Jalon and Bayo).
"""

from math import cos, sin, sqrt, tanh

from benchmarks.truth import box
from benchmarks.truth._jit import compiled
from benchmarks.truth.effects import hunt_crossley, soft_pad, viscoelastic_object
from benchmarks.truth.laws import onset


@compiled
def pressed(depth, rate, law, dented, gain):
    """Normal force (N), never pulling; the dent (m) and its rate.

    depth (m) and its rate: of the capsule in the object; dented: the dent at the step's start.
    """
    stiffness, damping, _, width, _, exponent, dissipation, share, time, _, _ = law
    dent, a, b = dented, 0.0, 0.0
    if share > 0.0:
        dent, a, b = viscoelastic_object.dent(dented, gain, depth, share, time)
    force = 0.0
    if depth > 0.0:
        force = damping * rate * onset(depth, width)
    if depth > dent:
        force += hunt_crossley.elastic(depth - dent, rate, stiffness, exponent, dissipation)
    elif depth > 0.0:
        force += stiffness * (depth - dent)
    return max(0.0, force), dent, a - b * dent


@compiled
def contact(ends, speeds, disc, law, dented, gain):
    """Force on rod ends A and B (N; 4), normal force and push on the face (N), dent and its rate.

    ends, speeds: ax, ay, bx, by (m, m/s). disc: centre x, y and radius, the capsule's own radius,
    half sizes of the box that the radius surrounds (m; none: 0). law: stiffness (N/m), damping
    (N s/m), friction, onset (m), slip speed (m/s);
    exponent, dissipation; share, time (s); thickness (m) and stiffness (N/m) of a pad.
    """
    ax, ay, bx, by = ends
    avx, avy, bvx, bvy = speeds
    cx, cy, radius, finger_radius, half_x, half_y = disc
    if radius <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, dented, 0.0
    ex, ey = bx - ax, by - ay
    length2 = ex * ex + ey * ey
    if half_x > 0.0 or half_y > 0.0:
        along, distance, nx, ny = box.nearest(ax - cx, ay - cy, ex, ey, half_x, half_y)
    else:
        along = min(max(((cx - ax) * ex + (cy - ay) * ey) / length2, 0.0), 1.0)
        dx, dy = cx - ax - along * ex, cy - ay - along * ey
        distance = sqrt(dx * dx + dy * dy)
        nx, ny = dx / distance, dy / distance
    depth = radius + finger_radius - distance
    if depth + law[9] <= 0.0:
        _, dent, dent_rate = pressed(depth, 0.0, law, dented, gain)
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, dent, dent_rate
    # The touching point as A + xi (B - A) + eta perp(B - A), perp(e) = (-ey, ex).
    xi = along + finger_radius * (nx * ex + ny * ey) / length2
    eta = finger_radius * (-nx * ey + ny * ex) / length2
    evx, evy = bvx - avx, bvy - avy
    vx, vy = avx + xi * evx - eta * evy, avy + xi * evy + eta * evx
    normal, dent, dent_rate = pressed(depth, vx * nx + vy * ny, law, dented, gain)
    normal += soft_pad.push(depth, law[9], law[10])
    drag = law[2] * normal * tanh((-vx * ny + vy * nx) / law[4])
    fx, fy = -normal * nx + drag * ny, -normal * ny - drag * nx
    return (
        (1.0 - xi) * fx - eta * fy,
        (1.0 - xi) * fy + eta * fx,
        xi * fx + eta * fy,
        xi * fy - eta * fx,
        normal,
        # The dynamometer's face looks to the fingertips and feels what presses it to the palm.
        fx if nx < 0.0 else 0.0,
        dent,
        dent_rate,
    )


@compiled
def finger(angles, speeds, torques, lengths, masses, gravity, disc, law, dents, gain):
    """Angular accelerations (rad/s2) of MCP and PIP; dents and their rates; normal force and push.

    angles, speeds, torques: MCP, PIP; lengths, masses: proximal, distal rod; gravity (m/s2) and
    disc (see `contact`): in the finger's plane, whose origin is the MCP axis; dents: one for each
    rod, at the start of a part-step of `gain`.
    """
    (q1, q2), (w1, w2), (torque1, torque2) = angles, speeds, torques
    (l1, l2), (m1, m2), (gx, gy) = lengths, masses, gravity
    a, va = q1 + q2, w1 + w2  # absolute angle and speed of the distal rod
    u1x, u1y, u2x, u2y = l1 * cos(q1), -l1 * sin(q1), l2 * cos(a), -l2 * sin(a)
    # d/da (cos, -sin) = (-sin, -cos): turn (x, y) into (y, -x).
    t1x, t1y, t2x, t2y = u1y, -u1x, u2y, -u2x
    px, py, vpx, vpy = u1x, u1y, t1x * w1, t1y * w1
    tx, ty, vtx, vty = px + u2x, py + u2y, vpx + t2x * va, vpy + t2y * va

    fx, fy = 0.5 * (m1 + m2) * gx, 0.5 * (m1 + m2) * gy
    hx, hy = 0.5 * m2 * gx, 0.5 * m2 * gy
    near = contact((0.0, 0.0, px, py), (0.0, 0.0, vpx, vpy), disc, law, dents[0], gain)
    far = contact((px, py, tx, ty), (vpx, vpy, vtx, vty), disc, law, dents[1], gain)
    fx, fy = fx + near[2] + far[0], fy + near[3] + far[1]
    hx, hy = hx + far[2], hy + far[3]

    # Accelerations of P and T at constant joint speeds (R' q'), and what they ask of M.
    apx, apy = -u1x * w1 * w1, -u1y * w1 * w1
    atx, aty = apx - u2x * va * va, apy - u2y * va * va
    mpp, mpt, mtt = (m1 + m2) / 3.0, m2 / 6.0, m2 / 3.0
    fx, fy = fx - mpp * apx - mpt * atx, fy - mpp * apy - mpt * aty
    hx, hy = hx - mpt * apx - mtt * atx, hy - mpt * apy - mtt * aty

    # Columns of R for (q1, q2): P moves by t1, 0; T by t1 + t2, t2.
    sx, sy = t1x + t2x, t1y + t2y
    m11 = mpp * (t1x * t1x + t1y * t1y) + 2.0 * mpt * (t1x * sx + t1y * sy)
    m11 += mtt * (sx * sx + sy * sy)
    m12 = mpt * (t1x * t2x + t1y * t2y) + mtt * (sx * t2x + sy * t2y)
    m22 = mtt * (t2x * t2x + t2y * t2y)
    b1 = torque1 + t1x * fx + t1y * fy + sx * hx + sy * hy
    b2 = torque2 + t2x * hx + t2y * hy
    det = m11 * m22 - m12 * m12
    accelerations = (m22 * b1 - m12 * b2) / det, (m11 * b2 - m12 * b1) / det
    dented = near[6], far[6], near[7], far[7]
    return accelerations, dented, near[4] + far[4], near[5] + far[5]
