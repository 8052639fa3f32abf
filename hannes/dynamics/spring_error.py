"""Return-spring error: re-opening springs stronger or weaker than nominal."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter
from hannes.dynamics.joints import spring_torque


@kernel
def stronger(joint_angle, rest, joint_spring_stiffness, joint_spring_preload, share):
    """Added re-opening torque of a joint [N m]: share of preload and stiffness alike."""
    return share * spring_torque(joint_angle, rest, joint_spring_stiffness, joint_spring_preload)


EFFECT = Effect(
    name="spring_error",
    meaning="The springs that open the hand are stronger or weaker than nominal.",
    equation="T_open += share (preload + k (q - q_rest))",
    source="Hooke's law off its nominal rate; EN 13906-3 (2014), torsion springs",
    parameters=(
        Parameter("share", 0.0, "1", (-0.9, 0.9), "of the nominal spring torque", off=0.0),
    ),
    terms=(Term(stronger, writes=("spring_torque",)),),
)
