"""What has no name: torque or friction over an angle, of motor or joints, and tension that eases.

No catalogue has them: rivals to all names. What one takes of the misfit as well as a named effect
does, something else may have made too, and the name is not told; what it takes alone is `unknown`.
Each stands alone, as few numbers see more than many. That load, joints, their friction and what a
run has borne before are in them was chosen on development cases of effects outside the catalogue:
the motor's angle alone does not see an eccentric pulley, nor hardly a spring that is not linear, no
torque that goes with angles alone a joint that rubs at one of them, or a wire that creeps.
"""

import math

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter

OUTPUT_RANGE = (
    10.0  # rad, at the output shaft, in which the hand closes: beyond, waves are mirrored
)
JOINT_RANGE = 1.5  # rad, in which a joint closes
SMOOTHING_SPEED = 0.2  # rad/s, below which friction of a joint turns


@kernel
def torque_series(
    motor_angle, gear_ratio, load, free_1, free_2, free_3, free_4, free_5,
    loaded_1, loaded_2, loaded_3, loaded_4,
):  # fmt: skip
    """Torque on the rotor [N m]: cosines of the angle, and the load's torque times others."""
    u = math.pi * motor_angle / (OUTPUT_RANGE * gear_ratio)
    one, two, three, four = math.cos(u), math.cos(2.0 * u), math.cos(3.0 * u), math.cos(4.0 * u)
    free = free_1 * one + free_2 * two + free_3 * three + free_4 * four
    of_load = loaded_1 * one + loaded_2 * two + loaded_3 * three + loaded_4 * four
    return free + free_5 * math.cos(5.0 * u) + load * of_load


@kernel
def opening_series(joint_angle, rest, legendre_2, legendre_3, legendre_4):
    """Torque that opens a joint [N m]: Legendre's polynomials of the way that it has closed."""
    x = 2.0 * (joint_angle - rest) / JOINT_RANGE - 1.0
    q = x * x
    second, third = 1.5 * q - 0.5, x * (2.5 * q - 1.5)
    return legendre_2 * second + legendre_3 * third + legendre_4 * (q * (4.375 * q - 3.75) + 0.375)


@kernel
def friction_series(joint_angle, joint_speed, rest, drag_1, drag_2, drag_3):
    """Torque against a joint's motion [N m]: Legendre's polynomials of the way it has closed."""
    x = 2.0 * (joint_angle - rest) / JOINT_RANGE - 1.0
    q = x * x
    against = drag_1 * x + drag_2 * (1.5 * q - 0.5) + drag_3 * x * (2.5 * q - 1.5)
    return math.tanh(joint_speed / SMOOTHING_SPEED) * against


@kernel
def easing_tension(leader_tension, eased, easing_rate):
    """Tension that a pull has lost to what it bore before [N], and the rate at which it does."""
    lost = min(leader_tension, eased)
    return -lost, easing_rate * (leader_tension - lost)


def _wave(name: str, number: int, unit: str, most: float) -> Parameter:
    return Parameter(f"{name}_{number}", 0.0, unit, (-most, most), "of a wave", "choice", off=0.0)


TORQUE = Effect(
    name="any_torque",
    meaning="The motor is pulled by something that goes with its angle, and the load.",
    equation="J w' += sum (free_k + loaded_k tl) cos(k pi th / (N travel))",
    source="Fourier's series",
    parameters=(
        *(_wave("free", k, "N m", 0.01) for k in range(1, 6)),
        *(_wave("loaded", k, "1", 0.2) for k in range(1, 5)),
    ),
    terms=(Term(torque_series, writes=("motor_torque",), unit="N m"),),
)
OPENING = Effect(
    name="any_opening",
    meaning="Joints are pulled by something that goes with their angles, the same for all.",
    equation="T_open += sum bent_k P_k(2 (q - q_rest) / bent - 1)",
    source="Legendre's polynomials",
    parameters=tuple(_wave("legendre", k, "N m", 0.05) for k in range(2, 5)),
    terms=(Term(opening_series, writes=("spring_torque",), unit="N m"),),
)
DRAGGING = Effect(
    name="any_dragging",
    meaning="Joints rub by what goes with their angles, the same for all.",
    equation="T_open += tanh(q' / crawl) sum drag_k P_k(2 (q - q_rest) / bent - 1)",
    source="Legendre's polynomials",
    parameters=tuple(_wave("drag", k, "N m", 0.05) for k in range(1, 4)),
    terms=(Term(friction_series, writes=("spring_torque",), unit="N m"),),
)
EASING = Effect(
    name="any_easing",
    meaning="The leader pulls less, the more it has borne before.",
    equation="T_L -= min(e, T_L), e' = easing_rate max(T_L - e, 0)",
    source="Maxwell (1867)",
    parameters=(
        Parameter("easing_rate", 0.0, "1/s", (0.0, 1.0), "of the tension", "choice", off=0.0),
    ),
    terms=(Term(easing_tension, writes=("leader_tension",), states=("eased",), unit="N"),),
    states=(Slot("eased", "N", "tension that is lost", tolerance=1e-4),),
)
EFFECTS = (TORQUE, OPENING, DRAGGING, EASING)
GENERIC_NAMES = {
    TORQUE.name: "any torque over the motor's angle",
    OPENING.name: "any torque over joints' angles",
    DRAGGING.name: "any friction over joints' angles",
    EASING.name: "tension that eases while it is borne",
}
