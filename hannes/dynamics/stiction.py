"""Stiction: dry friction with a memory, so that a body at rest is held and does not creep.

In equations 1 and 2 friction vanishes with speed, as it does between finger and object; a load
then creeps. Here the same levels are reached through a bristle that deflects first, and stays so.
"""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import soft_sign
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter
from hannes.dynamics.friction import stribeck


@kernel
def bending(speed, bristle, width):
    """Rate of a bristle [1/s] dragged at a speed, which turns over within a width."""
    return (speed - abs(speed) * bristle) / width


@kernel
def held_shaft(
    motor_speed, motor_dry_friction, motor_friction_speed, shaft_bristle, share, shaft_width
):
    """Added to motor and gear friction [N m], and the bristle's rate [1/s]."""
    added = shaft_bristle - soft_sign(motor_speed / motor_friction_speed)
    rate = bending(motor_speed, shaft_bristle, shaft_width)
    return share * motor_dry_friction * added, rate


@kernel
def held(speed, breakaway, coulomb, breakaway_speed, bristle):
    """What a bristle holds beyond equation 1 or 2, whose peak is carried down to standstill."""
    fastest = max(abs(speed), breakaway_speed)
    level = stribeck(fastest, breakaway, coulomb, breakaway_speed, 0.0)
    return level * bristle - stribeck(speed, breakaway, coulomb, breakaway_speed, 0.0)


@kernel
def held_cart(
    cart_speed,
    cart_breakaway_friction,
    cart_coulomb_friction,
    cart_breakaway_speed,
    cart_bristle,
    share,
    cart_width,
):
    """Added to a guide's friction [N], and the bristle's rate [1/s]."""
    added = held(
        cart_speed,
        cart_breakaway_friction,
        cart_coulomb_friction,
        cart_breakaway_speed,
        cart_bristle,
    )
    return share * added, bending(cart_speed, cart_bristle, cart_width)


@kernel
def held_joint(
    joint_speed,
    joint_breakaway_friction,
    joint_coulomb_friction,
    joint_breakaway_speed,
    joint_bristle,
    share,
    joint_width,
):
    """Added to a joint's friction [N m], and the bristle's rate [1/s]."""
    added = held(
        joint_speed,
        joint_breakaway_friction,
        joint_coulomb_friction,
        joint_breakaway_speed,
        joint_bristle,
    )
    return share * added, bending(joint_speed, joint_bristle, joint_width)


@kernel
def held_object(
    normal_force, slip_speed, object_friction, object_slip_speed, grip_bristle, share, grip_width
):
    """Added to the object's friction along a phalanx [N], and the bristle's rate [1/s]."""
    added = grip_bristle - soft_sign(slip_speed / object_slip_speed)
    rate = bending(slip_speed, grip_bristle, grip_width)
    return share * object_friction * normal_force * added, rate


LAW = Effect(
    name="stiction",
    meaning="What stands still stays so until its dry friction is overcome: a grip does not creep.",
    equation="T += share (T(max(|w|, w_bf)) z - T(w)), z' = (w - |w| z) / width",
    source="Dahl (1968), solid friction, with the levels of the paper's equations 1 and 2",
    parameters=(
        Parameter("share", 0.0, "1", (0.0, 1.0), "1 in the place of tanh, 0 not at all", off=0.0),
        Parameter("shaft_width", 0.2, "rad", (1e-3, 10), "motor angle for the friction to turn"),
        Parameter("cart_width", 5e-5, "m", (1e-6, 1e-2), "travel for the friction to turn"),
        Parameter("joint_width", 0.01, "rad", (1e-4, 1.0), "angle for the friction to turn"),
        Parameter("grip_width", 2e-4, "m", (1e-6, 1e-2), "slip for the friction to turn"),
    ),
    terms=(
        Term(held_shaft, writes=("gear_friction",), states=("shaft_bristle",)),
        Term(held_cart, writes=("cart_friction",), states=("cart_bristle",)),
        Term(held_joint, writes=("joint_friction",), states=("joint_bristle",)),
        Term(held_object, writes=("held_drag",), states=("grip_bristle",)),
    ),
    states=(
        Slot("shaft_bristle", "1", "z of motor and gear, closing positive", "", 1, 1e-3),
        Slot("cart_bristle", "1", "z of the guides, along the pull", "cart", 2, 1e-3),
        Slot("joint_bristle", "1", "z of the joints, closing positive", "joint", 10, 1e-3),
        Slot("grip_bristle", "1", "z of finger on object, by its slip", "phalanx", 10, 1e-3),
    ),
)
