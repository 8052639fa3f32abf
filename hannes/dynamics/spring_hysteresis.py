"""Return-spring hysteresis: springs that pull harder while loaded than while let go."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter
from hannes.dynamics.joints import spring_torque


@kernel
def rubbing(
    joint_angle,
    joint_speed,
    rest,
    joint_spring_stiffness,
    joint_spring_preload,
    turned,
    share,
    width,
):
    """Re-opening torque [N m] that turns with the direction of motion, and the turning's rate."""
    torque = spring_torque(joint_angle, rest, joint_spring_stiffness, joint_spring_preload)
    return share * torque * turned, (joint_speed - abs(joint_speed) * turned) / width


EFFECT = Effect(
    name="spring_hysteresis",
    meaning="The springs that open the hand give back less than was put into them.",
    equation="T_open += share (preload + k (q - q_rest)) z, z' = (q' - |q'| z) / width",
    source="Dahl (1968), solid friction, in proportion to the spring's torque",
    parameters=(
        Parameter("share", 0.0, "1", (0.0, 0.9), "of the nominal spring torque", off=0.0),
        # Wider, it would not have turned within a grasp, and be another spring.
        Parameter("width", 0.05, "rad", (1e-3, 0.3), "of joint angle for the torque to turn"),
    ),
    terms=(Term(rubbing, writes=("spring_torque",), states=("turned",)),),
    states=(Slot("turned", "1", "z, from -1 opening to 1 closing", "joint", 10, 1e-3),),
)
