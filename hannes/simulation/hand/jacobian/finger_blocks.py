"""Derivatives of the fingers' rates, mostly in closed form.

Text of the same kind as arrowhead.py, for sets of effects of which finger_effect_terms.py can
differentiate what they add. For all others there is finger_differences.py. Only where contacts lie
is differenced.
"""

from typing import Any

import numpy as np

from hannes.core.kernels.smooth_switches import one_sided_derivatives, smoothstep
from hannes.core.kernels.vector_math import soft_sign
from hannes.dynamics.friction import stribeck_slope
from hannes.simulation.hand.equations import contact

TURN = 1e-7  # rad, of a difference
# Filled in by sparsity.py; here those of the hand without effects.
OWN = np.array([[11 + k + 2 * f for f in range(5)] for k in (0, 1, 10, 11)])
SIZE = 4
TOUCHED = np.array([0])[:0]  # which of OWN have rates that depend on where contacts lie
joint_effects: Any = None  # these two written out by finger_effect_terms.py
contact_effects: Any = None


def finger_columns(t, y, moved, rates, dy, p, c, out, tensions, blocks):
    """Fill `blocks`: see workspace in arrowhead.py."""
    joint_derivatives(p, c)
    joint_effects(t, y, p, c, blocks)
    touching = 0.0
    if p.object_present > 0.5:
        touching = contact_effects(t, y, p, c, blocks)
        for phalanx in range(10):
            touching = max(touching, c.normal_force[phalanx])
    if touching > 0.0:
        press_derivatives(p, c)
        contact_derivatives(t, y, rates, dy, p, c, out, blocks)
    for f in range(5):
        weight_derivatives(p, c, f)
        solve_columns(y, rates, p, c, f, blocks)


def joint_derivatives(p, c):
    """Torque of a joint by its own angle and speed; by its finger's others as yet nothing."""
    for joint in range(p.rest.size):
        stiffness, damping = p.joint_stop_stiffness[joint], p.joint_stop_damping[joint]
        angle, speed, onset = c.lane_angle[joint], c.lane_speed[joint], p.joint_stop_onset[joint]
        depth = p.rest[joint] + p.joint_spring_preload[joint] / stiffness - angle
        low, slows = one_sided_derivatives(stiffness, damping, depth, -speed, onset)
        high, brakes = one_sided_derivatives(stiffness, damping, angle - p.end[joint], speed, onset)
        friction = stribeck_slope(
            speed,
            p.joint_breakaway_friction[joint],
            p.joint_coulomb_friction[joint],
            p.joint_breakaway_speed[joint],
            p.joint_viscous_friction[joint],
        )
        c.own_angle_slope[joint] = -p.joint_spring_stiffness[joint] - low - high
        c.own_speed_slope[joint] = -friction - slows - brakes
        c.mcp_angle_slope[joint], c.pip_angle_slope[joint] = 0.0, 0.0
        c.mcp_speed_slope[joint], c.pip_speed_slope[joint] = 0.0, 0.0


def press_derivatives(p, c):
    """Torque of the contacts by the speeds of MCP and PIP: of each phalanx, then of both."""
    for k in range(p.rest.size):
        normal, mcp, pip = c.normal_force[k], c.normal_arm_mcp[k], c.normal_arm_pip[k]
        slip_mcp, slip_pip = c.slip_arm_mcp[k], c.slip_arm_pip[k]
        pushes = 1.0 if normal > 0.0 else 0.0
        by_rate = pushes * p.object_damping * smoothstep(c.penetration[k] / p.object_onset)
        by_rate += c.pressing[k]
        grip = soft_sign(c.slip_speed[k] / p.object_slip_speed)
        drag = p.object_friction * grip
        by_slip = p.object_friction * normal * (1.0 - grip * grip) / p.object_slip_speed
        on_mcp, on_pip = (mcp - drag * slip_mcp) * by_rate, (pip - drag * slip_pip) * by_rate
        c.mcp_by_mcp[k] = -on_mcp * mcp - slip_mcp * by_slip * slip_mcp
        c.pip_by_mcp[k] = -on_pip * mcp - slip_pip * by_slip * slip_mcp
        c.mcp_by_pip[k] = -on_mcp * pip - slip_mcp * by_slip * slip_pip
        c.pip_by_pip[k] = -on_pip * pip - slip_pip * by_slip * slip_pip
        c.held_mcp[k], c.held_pip[k] = c.torque_mcp[k], c.torque_pip[k]
    for mcp in range(0, 10, 2):
        c.mcp_speed_slope[mcp] = c.mcp_by_mcp[mcp] + c.mcp_by_mcp[mcp + 1]
        c.mcp_speed_slope[mcp + 1] = c.pip_by_mcp[mcp] + c.pip_by_mcp[mcp + 1]
        c.pip_speed_slope[mcp] = c.mcp_by_pip[mcp] + c.mcp_by_pip[mcp + 1]
        c.pip_speed_slope[mcp + 1] = c.pip_by_pip[mcp] + c.pip_by_pip[mcp + 1]


def contact_derivatives(t, y, rates, dy, p, c, out, blocks):
    """Torque of the contacts by the angles of MCP and PIP, of what `press_derivatives` held."""
    turn(p, c, TURN, TURN)
    contact(t, y, dy, p, c, out)
    for mcp in range(0, 10, 2):
        c.mcp_angle_slope[mcp], c.mcp_angle_slope[mcp + 1] = torque_change(c, mcp)
    keep_touched(0, rates, dy, blocks)
    turn(p, c, -TURN, 0.0)
    contact(t, y, dy, p, c, out)
    for mcp in range(0, 10, 2):
        c.pip_angle_slope[mcp], c.pip_angle_slope[mcp + 1] = torque_change(c, mcp)
    keep_touched(1, rates, dy, blocks)
    turn(p, c, 0.0, -TURN)


def keep_touched(j, rates, dy, blocks):
    """Rates of effects' states in the contacts by the angle j."""
    for n in range(TOUCHED.size):
        for f in range(5):
            place = OWN[TOUCHED[n], f]
            blocks[TOUCHED[n], j, f] = (dy[place] - rates[place]) / TURN


def turn(p, c, first, second):
    """Turn the links before and beyond PIP by two small angles, to the second order."""
    for joint in range(p.rest.size):
        angle = first + p.distal[joint] * (second - first)
        cosine, sine = c.cosine[joint], c.sine[joint]
        c.cosine[joint] = cosine - angle * (sine + 0.5 * angle * cosine)
        c.sine[joint] = sine + angle * (cosine - 0.5 * angle * sine)


def torque_change(c, mcp):
    """How much more torque a finger's contacts put on MCP and PIP, per TURN."""
    pip = mcp + 1
    on_mcp = c.torque_mcp[mcp] - c.held_mcp[mcp] + c.torque_mcp[pip] - c.held_mcp[pip]
    on_pip = c.torque_pip[mcp] - c.held_pip[mcp] + c.torque_pip[pip] - c.held_pip[pip]
    return on_mcp / TURN, on_pip / TURN


def weight_derivatives(p, c, f):
    """Add the torque of the links' weight by the angles."""
    mcp, pip = 2 * f, 2 * f + 1
    gravity_x, gravity_y = p.gravity_x, p.gravity_y * p.facing[f]
    distal = 0.5 * p.link_mass[pip] * p.link_length[pip]
    distal *= c.sine[pip] * gravity_y - c.cosine[pip] * gravity_x
    whole = (0.5 * p.link_mass[mcp] + p.link_mass[pip]) * p.link_length[mcp]
    whole *= c.sine[mcp] * gravity_y - c.cosine[mcp] * gravity_x
    c.mcp_angle_slope[mcp] += whole + distal
    c.mcp_angle_slope[pip] += distal
    c.pip_angle_slope[mcp] += distal
    c.pip_angle_slope[pip] += distal


def solve_columns(y, dy, p, c, f, blocks):
    """M times the derivatives of q'' are those of all torques less those of M times q''."""
    mcp, pip = 2 * f, 2 * f + 1
    length_1, length_2 = p.link_length[mcp], p.link_length[pip]
    mass_1, mass_2 = p.link_mass[mcp], p.link_mass[pip]
    inertia_2 = mass_2 * length_2 * length_2 / 3.0
    coupling = 0.5 * mass_2 * length_1 * length_2
    along, across = coupling * c.bend_cosine[pip], coupling * c.bend_sine[pip]
    m_11 = (mass_1 / 3.0 + mass_2) * length_1 * length_1 + inertia_2 + 2.0 * along
    m_12 = inertia_2 + along
    inverse = 1.0 / (m_11 * inertia_2 - m_12 * m_12)
    rods = (inverse * m_11, inverse * m_12, inverse * inertia_2)
    w_1, w_2 = y.joint_speed[mcp], y.joint_speed[pip]
    a_1, a_2 = dy.joint_speed[mcp], dy.joint_speed[pip]
    by_bend_1 = along * (2.0 * w_1 + w_2) * w_2 + across * (2.0 * a_1 + a_2)
    by_bend_2 = across * a_1 - along * w_1 * w_1
    first = c.mcp_angle_slope[mcp] + c.own_angle_slope[mcp]
    solve_column(blocks, 0, f, rods, first, c.mcp_angle_slope[pip])
    second = c.pip_angle_slope[pip] + c.own_angle_slope[pip] + by_bend_2
    solve_column(blocks, 1, f, rods, c.pip_angle_slope[mcp] + by_bend_1, second)
    first = c.mcp_speed_slope[mcp] + c.own_speed_slope[mcp] + 2.0 * across * w_2
    solve_column(blocks, 2, f, rods, first, c.mcp_speed_slope[pip] - 2.0 * across * w_1)
    first = c.pip_speed_slope[mcp] + 2.0 * across * (w_1 + w_2)
    solve_column(blocks, 3, f, rods, first, c.pip_speed_slope[pip] + c.own_speed_slope[pip])
    solve_column(blocks, SIZE, f, rods, p.joint_moment_arm[mcp], p.joint_moment_arm[pip])
    for j in range(4, SIZE):
        solve_column(blocks, j, f, rods, blocks[2, j, f], blocks[3, j, f])
    blocks[0, 2, f], blocks[1, 3, f] = 1.0, 1.0


def solve_column(blocks, j, f, rods, first, second):
    """Accelerations by torques on MCP and PIP."""
    m_11, m_12, m_22 = rods
    blocks[2, j, f] = m_22 * first - m_12 * second
    blocks[3, j, f] = m_11 * second - m_12 * first
