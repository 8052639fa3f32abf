"""Generic disturbances: torque or friction as series over an angle, and relaxing tension.

They stand for effects outside the catalogue, as rivals to all names. Where one explains as much as
a named effect, something else may be the cause, and the effect is not named. What it explains
alone is `unknown`. Each is fitted alone, as few parameters are visible beside each other. Load,
joints, joint friction and tension history were included after development cases with effects
outside the catalogue. The motor angle alone misses an eccentric pulley, and nearly a nonlinear
spring. No torque over angles shows a joint that rubs at one of them, or a wire that creeps.
"""

import math

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter

OUTPUT_RANGE = 10.0  # rad, at the output shaft, of a whole closure: the series is mirrored beyond
JOINT_RANGE = 1.5  # rad, of a joint from open to closed
SMOOTHING_SPEED = 0.2  # rad/s, below which joint friction changes sign smoothly


@kernel
def torque_series(
    motor_angle, gear_ratio, load, free_1, free_2, free_3, free_4, free_5,
    loaded_1, loaded_2, loaded_3, loaded_4,
):  # fmt: skip
    """Torque on the rotor [N m]: cosines of the angle, and of the load's torque times others."""
    u = math.pi * motor_angle / (OUTPUT_RANGE * gear_ratio)
    one, two, three, four = math.cos(u), math.cos(2.0 * u), math.cos(3.0 * u), math.cos(4.0 * u)
    free = free_1 * one + free_2 * two + free_3 * three + free_4 * four
    of_load = loaded_1 * one + loaded_2 * two + loaded_3 * three + loaded_4 * four
    return free + free_5 * math.cos(5.0 * u) + load * of_load


@kernel
def opening_series(joint_angle, rest, legendre_2, legendre_3, legendre_4):
    """Torque that opens a joint [N m]: Legendre polynomials of its angle."""
    x = 2.0 * (joint_angle - rest) / JOINT_RANGE - 1.0
    q = x * x
    second, third = 1.5 * q - 0.5, x * (2.5 * q - 1.5)
    return legendre_2 * second + legendre_3 * third + legendre_4 * (q * (4.375 * q - 3.75) + 0.375)


@kernel
def friction_series(joint_angle, joint_speed, rest, drag_1, drag_2, drag_3):
    """Torque against a joint's motion [N m]: Legendre polynomials of its angle."""
    x = 2.0 * (joint_angle - rest) / JOINT_RANGE - 1.0
    q = x * x
    against = drag_1 * x + drag_2 * (1.5 * q - 0.5) + drag_3 * x * (2.5 * q - 1.5)
    return math.tanh(joint_speed / SMOOTHING_SPEED) * against


@kernel
def easing_tension(leader_tension, eased, easing_rate):
    """Tension lost to earlier load [N], and the rate at which it is lost."""
    lost = min(leader_tension, eased)
    return -lost, easing_rate * (leader_tension - lost)


def _wave(name: str, number: int, unit: str, most: float) -> Parameter:
    return Parameter(
        f"{name}_{number}", 0.0, unit, (-most, most), "series coefficient", "choice", off=0.0
    )


TORQUE = Effect(
    name="any_torque",
    meaning="A torque on the motor depends on its angle, and on the load.",
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
    meaning="A torque on every joint depends on its angle.",
    equation="T_open += sum legendre_k P_k(2 (q - q_rest) / range - 1)",
    source="Legendre's polynomials",
    parameters=tuple(_wave("legendre", k, "N m", 0.05) for k in range(2, 5)),
    terms=(Term(opening_series, writes=("spring_torque",), unit="N m"),),
)
DRAGGING = Effect(
    name="any_dragging",
    meaning="The friction of every joint depends on its angle.",
    equation="T_open += tanh(q' / v0) sum drag_k P_k(2 (q - q_rest) / range - 1)",
    source="Legendre's polynomials",
    parameters=tuple(_wave("drag", k, "N m", 0.05) for k in range(1, 4)),
    terms=(Term(friction_series, writes=("spring_torque",), unit="N m"),),
)
EASING = Effect(
    name="any_easing",
    meaning="The leader's tension relaxes under load.",
    equation="T_L -= min(e, T_L), e' = easing_rate max(T_L - e, 0)",
    source="Maxwell (1867)",
    parameters=(
        Parameter(
            "easing_rate", 0.0, "1/s", (0.0, 1.0), "of the relaxing tension", "choice", off=0.0
        ),
    ),
    terms=(Term(easing_tension, writes=("leader_tension",), states=("eased",), unit="N"),),
    states=(Slot("eased", "N", "tension lost", tolerance=1e-4),),
)
EFFECTS = (TORQUE, OPENING, DRAGGING, EASING)
GENERIC_NAMES = {
    TORQUE.name: "a torque over the motor's angle",
    OPENING.name: "a torque over joints' angles",
    DRAGGING.name: "a friction over joints' angles",
    EASING.name: "tension that relaxes under load",
}
