"""Passive torques of the joints: friction, return springs, stops."""

from benchmarks.truth._jit import compiled
from benchmarks.truth.added import joint_torque
from benchmarks.truth.effects import (
    friction_step,
    jammed_finger,
    nonlinear_spring,
    spring_error,
    spring_hysteresis,
)
from benchmarks.truth.laws import friction, held, one_sided
from benchmarks.truth.state import ANGLE, HYSTERESIS, SPEED


@compiled
def spring(h, joint, stiffness, preload, bend, start, gain, y, dy):
    """Re-opening torque (N m); writes the spring's hysteresis and its rate."""
    torque = preload + stiffness * bend
    out = spring_error.real(h, torque) + nonlinear_spring.stiffening(h, bend)
    if h.spring_hysteresis_share != 0.0:
        place = HYSTERESIS + joint
        a, b = spring_hysteresis.dahl(h, y[SPEED + joint])
        y[place] = held(start[place], gain, a, b)
        dy[place] = a - b * y[place]
        out += spring_hysteresis.lost(h, torque, y[place])
    return out


@compiled
def stops(angle, speed, limits, preload, stop):
    """Torque (N m, closing positive) of both stops; limits: rest and closing stop (rad).

    The lower stop starts where it carries the preload at the rest angle: rest is an equilibrium.
    """
    rest, upper = limits
    low = one_sided(rest + preload / stop[0] - angle, -speed, stop[0], stop[1], stop[2])
    return low - one_sided(angle - upper, speed, stop[0], stop[1], stop[2])


@compiled
def mcp_torque(h, f, start, gain, y, dy):
    """Passive torque (N m, closing positive) of finger f's MCP joint."""
    joint = 2 * f
    angle, speed, rest = y[ANGLE + joint], y[SPEED + joint], h.fingers_mcp_rest[f]
    upper = jammed_finger.end(h, f, rest, h.fingers_mcp_upper[f])
    stop = (h.mcp_stop_stiffness, h.mcp_stop_damping, h.mcp_stop_onset)
    drag = friction(
        speed,
        h.mcp_breakaway_friction * h.finger_share_mcp_breakaway_friction[f],
        h.mcp_coulomb_friction * h.finger_share_mcp_coulomb_friction[f],
        h.mcp_breakaway_speed,
        h.mcp_viscous_friction * h.finger_share_mcp_viscous_friction[f],
    )
    drag += friction_step.drag(h, joint, angle, speed, h.mcp_breakaway_speed)
    drag += joint_torque(h, joint, angle, speed)
    stiffness = h.mcp_spring_stiffness * h.finger_share_mcp_spring_stiffness[f]
    preload = h.mcp_spring_preload * h.finger_share_mcp_spring_preload[f]
    open_ = spring(h, joint, stiffness, preload, angle - rest, start, gain, y, dy)
    return stops(angle, speed, (rest, upper), preload, stop) - open_ - drag


@compiled
def pip_torque(h, f, start, gain, y, dy):
    """Passive torque (N m, closing positive) of finger f's PIP joint."""
    joint = 2 * f + 1
    angle, speed, rest = y[ANGLE + joint], y[SPEED + joint], h.fingers_pip_rest[f]
    upper = jammed_finger.end(h, f, rest, h.fingers_pip_upper[f])
    stop = (h.pip_stop_stiffness, h.pip_stop_damping, h.pip_stop_onset)
    drag = friction(
        speed,
        h.pip_breakaway_friction * h.finger_share_pip_breakaway_friction[f],
        h.pip_coulomb_friction * h.finger_share_pip_coulomb_friction[f],
        h.pip_breakaway_speed,
        h.pip_viscous_friction * h.finger_share_pip_viscous_friction[f],
    )
    drag += friction_step.drag(h, joint, angle, speed, h.pip_breakaway_speed)
    drag += joint_torque(h, joint, angle, speed)
    stiffness = h.pip_spring_stiffness * h.finger_share_pip_spring_stiffness[f]
    preload = h.pip_spring_preload * h.finger_share_pip_spring_preload[f]
    open_ = spring(h, joint, stiffness, preload, angle - rest, start, gain, y, dy)
    return stops(angle, speed, (rest, upper), preload, stop) - open_ - drag
