"""Derivatives of tensions and core in closed form, where effects leave their stages as they are.

Text of the same kind as arrow.py, for sets of effects that add to controller, motor, wires and
carts nothing but constants; the gear's stage, where much may rub, is differenced. For all others
there is core_differences.py.
"""

import numpy as np

from hannes.control.pid import pid, pid_slopes, saturated
from hannes.dynamics.friction import stribeck_slope
from hannes.equations import gear, position_reference
from hannes.onset import one_sided_slopes

# Columns of the core as structure.py orders it; their rates lie in the rows beyond the tensions.
CART_A, CART_A_SPEED = 0, 2
ANGLE, SPEED, CURRENT, INTEGRAL, LAG, CURRENT_INTEGRAL, CURRENT_LAG = range(4, 11)
RATE, COUNT = 5, 11
CORE = np.array([7, 8, 9, 10, 0, 1, 2, 3, 4, 5, 6])  # places of the columns' states
steps = np.full(31, 1e-3)  # filled in by assemble.py


def core_columns(t, y, moved, rates, dy, drift, p, c, reference, hold, out, core, tensions):
    """Fill `core` and `drift`, df/dt; see workspace in arrow.py."""
    drift[:] = 0.0
    core[CURRENT, RATE + CURRENT] = 0.0
    if p.controller_sampled < 0.5:
        later = t + 1e-7 * max(1.0, abs(t))
        target = position_reference(t, y, dy, p, c, reference, out)
        change = position_reference(later, y, dy, p, c, reference, out) - target
        controller_columns(y, p, target, change / (later - t), core, drift)
    core[CURRENT, RATE + CURRENT] -= p.motor_resistance / p.motor_inductance
    core[SPEED, RATE + CURRENT] = -p.motor_torque_constant / p.motor_inductance
    by_stretch, by_rate = one_sided_slopes(
        c.leader_stiffness, p.leader_damping, c.leader_stretch, c.leader_rate, p.wires_onset
    )
    arm = p.gear_pulley_radius / p.gear_ratio
    leader_column(p, core, ANGLE, arm * by_stretch)
    leader_column(p, core, SPEED, arm * by_rate)
    leader_column(p, core, COUNT + 4, -by_stretch)
    leader_column(p, core, COUNT + 9, -by_rate)
    for cart in range(2):
        leader_column(p, core, CART_A + cart, -2.0 * by_stretch)
        leader_column(p, core, CART_A_SPEED + cart, -2.0 * by_rate)
        cart_columns(y, p, c, cart, core)
    gear_columns(t, y, moved, dy, p, c, arm, out, core)


def controller_columns(y, p, target, target_rate, core, drift):
    """Both PIDs, the second one following the first, and the winding's voltage."""
    angle, current, ratio = y.motor_angle, y.motor_current, p.gear_ratio
    gain, lag = p.position_pid_proportional, p.position_pid_filter
    rule = (gain, p.position_pid_integral, p.position_pid_derivative, lag)
    speed = (angle - y.position_lag) / lag
    wanted = pid(target * ratio - angle, y.position_integral, speed, gain, rule[2])
    asked = saturated(wanted, p.position_pid_limit)
    by, integral = pid_slopes(wanted, p.position_pid_limit, *rule)
    core[ANGLE, RATE + LAG], core[LAG, RATE + LAG] = 1.0 / lag, -1.0 / lag
    core[ANGLE, RATE + INTEGRAL] = integral[1]
    core[INTEGRAL, RATE + INTEGRAL], core[LAG, RATE + INTEGRAL] = integral[2], integral[3]
    drift[CORE[INTEGRAL]] = integral[0] * ratio * target_rate

    gain, lag = p.current_pid_proportional, p.current_pid_filter
    rule = (gain, p.current_pid_integral, p.current_pid_derivative, lag)
    rise = (current - y.current_lag) / lag
    wanted = pid(asked - current, y.current_integral, rise, gain, rule[2])
    voltage, kept = pid_slopes(wanted, p.supply_voltage, *rule)
    core[CURRENT, RATE + CURRENT_LAG], core[CURRENT_LAG, RATE + CURRENT_LAG] = 1.0 / lag, -1.0 / lag
    for row, slopes in ((CURRENT, voltage), (CURRENT_INTEGRAL, kept)):
        per = 1.0 / p.motor_inductance if row == CURRENT else 1.0
        drift[CORE[row]] = per * slopes[0] * by[0] * ratio * target_rate
        core[ANGLE, RATE + row] = per * slopes[0] * by[1]
        core[INTEGRAL, RATE + row] = per * slopes[0] * by[2]
        core[LAG, RATE + row] = per * slopes[0] * by[3]
        core[CURRENT, RATE + row] = per * slopes[1]
        core[CURRENT_INTEGRAL, RATE + row] = per * slopes[2]
        core[CURRENT_LAG, RATE + row] = per * slopes[3]


def leader_column(p, core, column, pull):
    """The leader's tension, and how it pulls the carts."""
    core[column, 4] = pull
    for cart in range(2):
        core[column, RATE + CART_A_SPEED + cart] = 2.0 * pull / p.cart_mass


def cart_columns(y, p, c, cart, core):
    """A follower's tension and its pull, and the friction of its cart."""
    by_stretch, by_rate = one_sided_slopes(
        c.follower_stiffness,
        p.follower_damping,
        c.follower_stretch[cart],
        c.follower_rate[cart],
        p.wires_onset,
    )
    row, first = RATE + CART_A_SPEED + cart, 2 * cart
    core[CART_A_SPEED + cart, RATE + CART_A + cart] = 1.0
    for slope, column, taken in (
        (by_stretch, CART_A + cart, COUNT + first),
        (by_rate, CART_A_SPEED + cart, COUNT + 5 + first),
    ):
        core[column, first], core[column, first + 1] = 2.0 * slope, 2.0 * slope
        core[column, row] -= 4.0 * slope / p.cart_mass
        for finger in range(2):
            core[taken + finger, first], core[taken + finger, first + 1] = -slope, -slope
            core[taken + finger, row] = 2.0 * slope / p.cart_mass
    friction = stribeck_slope(
        y.cart_speed[cart],
        p.cart_breakaway_friction,
        p.cart_coulomb_friction,
        p.cart_breakaway_speed,
        p.cart_viscous_friction,
    )
    core[CART_A_SPEED + cart, row] -= friction / p.cart_mass


def gear_columns(t, y, moved, dy, p, c, arm, out, core):
    """The rotor's rate by its own states and by the leader's tension."""
    constant, load = p.motor_torque_constant, arm * c.leader_pull[0]
    gear(t, y, dy, p, c, constant, load, out)
    base = dy.motor_speed
    gear(t, y, dy, p, c, constant, load + 1e-6, out)
    by_tension = arm * 1e6 * (dy.motor_speed - base)
    for column in range(COUNT + 10):
        core[column, RATE + SPEED] = by_tension * core[column, 4]
    for column in range(ANGLE, CURRENT + 1):
        place = CORE[column]
        moved[place] += 1e-7 * max(abs(y[place]), steps[place])
        gear(t, moved, dy, p, c, constant, load, out)
        core[column, RATE + SPEED] += (dy.motor_speed - base) / (moved[place] - y[place])
        moved[place] = y[place]
    core[SPEED, RATE + ANGLE] = 1.0
