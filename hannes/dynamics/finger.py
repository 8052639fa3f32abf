"""A finger as two planar links: mass matrix, Coriolis and gravity terms, point kinematics.

Angles close the finger: the link direction is (cos q, -sin q) in the finger's plane. Links are
slender uniform rods.
"""

import math

from hannes.core.kernels.jit import kernel


@kernel
def solve_inertia(
    torque_1, torque_2, cosine, sine, speed_1, speed_2, length_1, length_2, mass_1, mass_2
):
    """Solve M(q) q'' + c(q, q') = torque for both joints: returns q'' [rad/s2] (2 scalars).

    `torque` [N m] holds everything that acts on a joint; `cosine` and `sine` are those of the
    second joint's angle; lengths [m], masses [kg].
    """
    inertia_1 = mass_1 * length_1 * length_1 / 3.0 + mass_2 * length_1 * length_1
    inertia_2 = mass_2 * length_2 * length_2 / 3.0
    coupling = 0.5 * mass_2 * length_1 * length_2
    m_11 = inertia_1 + inertia_2 + 2.0 * coupling * cosine
    m_12 = inertia_2 + coupling * cosine
    tau_1 = torque_1 + coupling * sine * (2.0 * speed_1 + speed_2) * speed_2
    tau_2 = torque_2 - coupling * sine * speed_1 * speed_1
    determinant = m_11 * inertia_2 - m_12 * m_12
    return (
        (inertia_2 * tau_1 - m_12 * tau_2) / determinant,
        (m_11 * tau_2 - m_12 * tau_1) / determinant,
    )


@kernel
def accelerations(
    torque_1, torque_2, angle_2, speed_1, speed_2, length_1, length_2, mass_1, mass_2
):
    """`solve_inertia` at the second joint's angle [rad]."""
    cosine, sine = math.cos(angle_2), math.sin(angle_2)
    rods = (length_1, length_2, mass_1, mass_2)
    return solve_inertia(torque_1, torque_2, cosine, sine, speed_1, speed_2, *rods)


@kernel
def kinetic_energy(angle_2, speed_1, speed_2, length_1, length_2, mass_1, mass_2):
    """Kinetic energy of one finger [J]."""
    inertia_2 = mass_2 * length_2 * length_2 / 3.0
    coupling = 0.5 * mass_2 * length_1 * length_2 * math.cos(angle_2)
    m_11 = (mass_1 / 3.0 + mass_2) * length_1 * length_1 + inertia_2 + 2.0 * coupling
    m_12 = inertia_2 + coupling
    return 0.5 * m_11 * speed_1 * speed_1 + m_12 * speed_1 * speed_2 + 0.5 * inertia_2 * speed_2**2


@kernel
def gravity_torque(angle_1, angle_2, g_x, g_y, length_1, length_2, mass_1, mass_2):
    """Torque of gravity on MCP and PIP [N m]; g_x, g_y [m/s2] in the finger's plane."""
    direction = angle_1 + angle_2
    first = -math.sin(angle_1) * g_x - math.cos(angle_1) * g_y
    second = -math.sin(direction) * g_x - math.cos(direction) * g_y
    distal = 0.5 * mass_2 * length_2 * second
    return (0.5 * mass_1 + mass_2) * length_1 * first + distal, distal


@kernel
def link_frame(link, angle_1, angle_2, length_1):
    """Start point [m] and unit direction of link 0 or 1 in the finger's plane (4 scalars)."""
    if link == 0:
        return 0.0, 0.0, math.cos(angle_1), -math.sin(angle_1)
    direction = angle_1 + angle_2
    start_x, start_y = length_1 * math.cos(angle_1), -length_1 * math.sin(angle_1)
    return start_x, start_y, math.cos(direction), -math.sin(direction)
