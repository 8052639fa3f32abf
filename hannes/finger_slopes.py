"""Derivatives of the fingers' rates, mostly in closed form, where effects leave them as they are.

Text of the same kind as arrow.py, for sets of effects that add nothing to joints and contacts;
for all others there is finger_differences.py. Only where contacts lie is differenced.
"""

from hannes.dynamics.friction import stribeck_slope
from hannes.equations import contact
from hannes.lanes import lane_sign
from hannes.onset import one_sided_slopes, smoothstep

TURN = 1e-7  # rad, of a difference


def finger_columns(t, y, moved, rates, dy, p, c, out, tensions, blocks, lanes):
    """Fill `blocks`: see workspace in arrow.py."""
    joint_slopes(p, c, lanes)
    touching = 0.0
    if p.object_present > 0.5:
        for phalanx in range(10):
            touching = max(touching, c.normal_force[phalanx])
    if touching > 0.0:
        contact_slopes(t, y, dy, p, c, out, lanes)
    for f in range(5):
        weight_slopes(p, c, f, lanes)
        solve_columns(y, rates, p, c, f, blocks, lanes)


def joint_slopes(p, c, lanes):
    """Rows 0 and 1: torque of a joint by its own angle and speed; 2 to 5: nothing yet."""
    for joint in range(p.rest.size):
        end, lower = p.end[joint], p.joint_spring_preload[joint] / p.joint_stop_stiffness[joint]
        stiffness, damping = p.joint_stop_stiffness[joint], p.joint_stop_damping[joint]
        angle, speed, onset = c.lane_angle[joint], c.lane_speed[joint], p.joint_stop_onset[joint]
        depth = p.rest[joint] + lower - angle
        low = one_sided_slopes(stiffness, damping, depth, -speed, onset)
        high = one_sided_slopes(stiffness, damping, angle - end, speed, onset)
        friction = stribeck_slope(
            speed,
            p.joint_breakaway_friction[joint],
            p.joint_coulomb_friction[joint],
            p.joint_breakaway_speed[joint],
            p.joint_viscous_friction[joint],
        )
        lanes[0, joint] = -p.joint_spring_stiffness[joint] - low[0] - high[0]
        lanes[1, joint] = -friction - low[1] - high[1]
        lanes[2, joint] = lanes[3, joint] = lanes[4, joint] = lanes[5, joint] = 0.0


def contact_slopes(t, y, dy, p, c, out, lanes):
    """Rows 2 to 5: torque of the contacts by MCP's angle, PIP's, MCP's speed, PIP's."""
    press_slopes(p, c, lanes)
    for joint in range(p.rest.size):
        lanes[10, joint] = c.torque_mcp[joint]
        lanes[11, joint] = c.torque_pip[joint]
    for j in range(2):
        turn(p, c, lanes, j, TURN)
        contact(t, y, dy, p, c, out)
        for joint in range(p.rest.size):
            lanes[12, joint] = (c.torque_mcp[joint] - lanes[10, joint]) * (1.0 / TURN)
            lanes[13, joint] = (c.torque_pip[joint] - lanes[11, joint]) * (1.0 / TURN)
        turn(p, c, lanes, j, -TURN)
        for f in range(5):
            lanes[2 + j, 2 * f] = lanes[12, 2 * f] + lanes[12, 2 * f + 1]
            lanes[2 + j, 2 * f + 1] = lanes[13, 2 * f] + lanes[13, 2 * f + 1]


def turn(p, c, lanes, j, angle):
    """Turn all links by the angle at MCP (j = 0) or PIP (1), to the second order."""
    for joint in range(p.rest.size):
        by = angle if j == 0 else angle * p.distal[joint]
        cosine, sine = c.cosine[joint], c.sine[joint]
        c.cosine[joint] = cosine - by * sine - 0.5 * by * by * cosine
        c.sine[joint] = sine + by * cosine - 0.5 * by * by * sine


def press_slopes(p, c, lanes):
    """Rows 4 and 5: torque of the contacts by the speeds of MCP and PIP."""
    for k in range(p.rest.size):
        normal, mcp, pip = c.normal_force[k], c.normal_arm_mcp[k], c.normal_arm_pip[k]
        slip_mcp, slip_pip = c.slip_arm_mcp[k], c.slip_arm_pip[k]
        pushes = 1.0 if normal > 0.0 else 0.0
        by_rate = pushes * p.object_damping * smoothstep(c.penetration[k] / p.object_onset)
        grip = lane_sign(c.slip_speed[k] / p.object_slip_speed)
        drag = p.object_friction * grip
        by_slip = p.object_friction * normal * (1.0 - grip * grip) / p.object_slip_speed
        deeper_mcp, deeper_pip = -by_rate * mcp, -by_rate * pip
        lanes[6, k] = (mcp - drag * slip_mcp) * deeper_mcp - slip_mcp * by_slip * slip_mcp
        lanes[7, k] = (pip - drag * slip_pip) * deeper_mcp - slip_pip * by_slip * slip_mcp
        lanes[8, k] = (mcp - drag * slip_mcp) * deeper_pip - slip_mcp * by_slip * slip_pip
        lanes[9, k] = (pip - drag * slip_pip) * deeper_pip - slip_pip * by_slip * slip_pip
    for f in range(5):
        for j in range(2):
            for i in range(2):
                row = 6 + 2 * j + i
                lanes[4 + j, 2 * f + i] = lanes[row, 2 * f] + lanes[row, 2 * f + 1]


def weight_slopes(p, c, f, lanes):
    """Add the torque of the links' weight by the angles."""
    mcp, pip = 2 * f, 2 * f + 1
    gravity_x, gravity_y = p.gravity_x, p.gravity_y * p.facing[f]
    distal = 0.5 * p.link_mass[pip] * p.link_length[pip]
    distal *= c.sine[pip] * gravity_y - c.cosine[pip] * gravity_x
    whole = (0.5 * p.link_mass[mcp] + p.link_mass[pip]) * p.link_length[mcp]
    whole *= c.sine[mcp] * gravity_y - c.cosine[mcp] * gravity_x
    lanes[2, mcp] += whole + distal
    lanes[2, pip] += distal
    lanes[3, mcp] += distal
    lanes[3, pip] += distal


def solve_columns(y, dy, p, c, f, blocks, lanes):
    """M times the derivatives of q'' are those of all torques less those of M times q''."""
    mcp, pip = 2 * f, 2 * f + 1
    length_1, length_2 = p.link_length[mcp], p.link_length[pip]
    mass_1, mass_2 = p.link_mass[mcp], p.link_mass[pip]
    inertia_2 = mass_2 * length_2 * length_2 / 3.0
    coupling = 0.5 * mass_2 * length_1 * length_2
    along, across = coupling * c.bend_cosine[pip], coupling * c.bend_sine[pip]
    m_11 = (mass_1 / 3.0 + mass_2) * length_1 * length_1 + inertia_2 + 2.0 * along
    m_12 = inertia_2 + along
    per = 1.0 / (m_11 * inertia_2 - m_12 * m_12)
    w_1, w_2 = y.joint_speed[mcp], y.joint_speed[pip]
    a_1, a_2 = dy.joint_speed[mcp], dy.joint_speed[pip]
    bent_1 = along * (2.0 * w_1 + w_2) * w_2 + across * (2.0 * a_1 + a_2)
    bent_2 = -along * w_1 * w_1 + across * a_1
    columns = (
        (lanes[2, mcp] + lanes[0, mcp], lanes[2, pip]),
        (lanes[3, mcp] + bent_1, lanes[3, pip] + lanes[0, pip] + bent_2),
        (
            lanes[4, mcp] + lanes[1, mcp] + 2.0 * across * w_2,
            lanes[4, pip] - 2.0 * across * w_1,
        ),
        (lanes[5, mcp] + 2.0 * across * (w_1 + w_2), lanes[5, pip] + lanes[1, pip]),
        (p.joint_moment_arm[mcp], p.joint_moment_arm[pip]),
    )
    for j in range(5):
        first, second = columns[j]
        blocks[2, j, f] = per * (inertia_2 * first - m_12 * second)
        blocks[3, j, f] = per * (m_11 * second - m_12 * first)
    blocks[0, 2, f] = blocks[1, 3, f] = 1.0
