"""Winding heating: copper resists more and magnets weaken as the motor warms."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter

COPPER = 3.93e-3  # 1/K, of its resistance
MAGNET = -1.1e-3  # 1/K, of NdFeB's remanence


@kernel
def warm(motor_resistance, motor_torque_constant, rise):
    """Changes of resistance [ohm] and torque constant [N m/A], `rise` [K]."""
    return COPPER * rise * motor_resistance, MAGNET * rise * motor_torque_constant


EFFECT = Effect(
    name="winding_heating",
    meaning="The motor is warm: its winding resists more and its magnets pull less.",
    equation="R (1 + 3.93e-3 rise), k_t (1 - 1.1e-3 rise)",
    source="IEC 60028 (1925) for copper; Coey (2010) for NdFeB magnets",
    parameters=(
        Parameter("rise", 0.0, "K", (0.0, 200.0), "above the nominal temperature", off=0.0),
    ),
    terms=(Term(warm, writes=("resistance", "torque_constant")),),
)
