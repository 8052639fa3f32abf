"""Any torque over the motor's angle, and any over it that goes with the load: a rival to all names.

No catalogue has it. What it takes of the misfit as well as a named effect does, something else may
have made too, and the name is not told; what it takes alone is `unknown`. That the load is in it
was chosen on development cases of effects outside the catalogue: one of the angle alone does not
see an eccentric pulley.
"""

import math

from hannes._jit import kernel
from hannes.effect import Effect, Term
from hannes.parameter import Parameter

SPOKEN = "any torque over the motor's angle and load"
TRAVEL = 10.0  # rad, at the output shaft, in which the hand closes: beyond, waves are mirrored


@kernel
def anything(
    motor_angle, gear_ratio, load, free_1, free_2, free_3, free_4, free_5,
    loaded_1, loaded_2, loaded_3, loaded_4,
):  # fmt: skip
    """Torque on the rotor [N m]: cosines of the angle, and the load's torque times others."""
    u = math.pi * motor_angle / (TRAVEL * gear_ratio)
    one, two, three, four = math.cos(u), math.cos(2.0 * u), math.cos(3.0 * u), math.cos(4.0 * u)
    free = free_1 * one + free_2 * two + free_3 * three + free_4 * four
    of_load = loaded_1 * one + loaded_2 * two + loaded_3 * three + loaded_4 * four
    return free + free_5 * math.cos(5.0 * u) + load * of_load


def _wave(name: str, number: int, unit: str, most: float) -> Parameter:
    return Parameter(f"{name}_{number}", 0.0, unit, (-most, most), "of a wave", "choice", off=0.0)


EFFECT = Effect(
    name="any_torque",
    meaning="The motor is pulled by something that goes with its angle, or with angle and load.",
    equation="J w' += sum (free_k + loaded_k tl) cos(k pi th / (N travel))",
    source="a Fourier series",
    parameters=(
        *(_wave("free", k, "N m", 0.01) for k in range(1, 6)),
        *(_wave("loaded", k, "1", 0.2) for k in range(1, 5)),
    ),
    terms=(Term(anything, writes=("motor_torque",), unit="N m"),),
)
