"""Wires: what the fingers take up, how the wires stretch, and what they pull where."""

from benchmarks.truth._jit import compiled
from benchmarks.truth.added import loose_length
from benchmarks.truth.effects import (
    capstan,
    eccentric_pulley,
    leader_slack,
    stacked_wire,
    wire_compliance,
)
from benchmarks.truth.laws import one_sided
from benchmarks.truth.state import ANGLE, CART, CART_SPEED, CREPT, SHAFT, SHAFT_SPEED, SPEED


@compiled
def moment_arms(h, f):
    """Levers (m) of finger f's flexor about MCP and PIP."""
    mcp = h.mcp_moment_arm * h.finger_share_mcp_moment_arm[f]
    return mcp, h.pip_moment_arm * h.finger_share_pip_moment_arm[f]


@compiled
def excursion(h, y, f):
    """Flexor taken up by finger f (m) and its rate (m/s)."""
    i, j = 2 * f, 2 * f + 1
    r1, r2 = moment_arms(h, f)
    taken = r1 * (y[ANGLE + i] - h.fingers_mcp_rest[f])
    taken += r2 * (y[ANGLE + j] - h.fingers_pip_rest[f])
    return taken, r1 * y[SPEED + i] + r2 * y[SPEED + j]


@compiled
def follower_tensions(h, y, c):
    """Tensions (N) of the two ends of cart c's follower: index and middle, or ring and little."""
    one, one_rate = excursion(h, y, 2 * c)
    two, two_rate = excursion(h, y, 2 * c + 1)
    stretch = 2.0 * y[CART + c] - one - two
    rate = 2.0 * y[CART_SPEED + c] - one_rate - two_rate
    stiffness = wire_compliance.in_series(h.follower_stiffness, h.wire_compliance_follower)
    mean = one_sided(stretch, rate, stiffness, h.follower_damping, h.wires_onset)
    return capstan.shared(h, mean, 0.5 * (one_rate - two_rate))


@compiled
def leader_tension(h, y):
    """Tension (N) of the leader at the motor pulley, and the wire's lever there (m)."""
    thumb, thumb_rate = excursion(h, y, 4)
    wound, lever = eccentric_pulley.wound(h, y[SHAFT])
    more, further = stacked_wire.further(h, y[SHAFT])
    wound, lever = wound + more, lever + further
    stretch = wound - leader_slack.loose(h) - y[CREPT] - 2.0 * (y[CART] + y[CART + 1]) - thumb
    stretch -= loose_length(h, y[SHAFT])
    rate = lever * y[SHAFT_SPEED] - 2.0 * (y[CART_SPEED] + y[CART_SPEED + 1]) - thumb_rate
    stiffness = wire_compliance.in_series(h.leader_stiffness, h.wire_compliance_leader)
    return one_sided(stretch, rate, stiffness, h.leader_damping, h.wires_onset), lever


@compiled
def leader_pulls(h, y, tension):
    """Pulls (N) of the leader on cart A, on cart B and on the thumb, in the order of its way."""
    _, thumb = excursion(h, y, 4)
    a, b = y[CART_SPEED], y[CART_SPEED + 1]
    behind_a = capstan.passed(h, tension, a + 2.0 * b + thumb)
    returned = capstan.passed(h, behind_a, 2.0 * b + thumb)
    behind_b = capstan.passed(h, returned, b + thumb)
    return tension + behind_a, returned + behind_b, behind_b
