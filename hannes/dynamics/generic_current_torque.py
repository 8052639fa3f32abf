"""Generic disturbance: any torque beyond torque constant times current, over the current."""

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import legendre, placed

MOST = 2.5  # A


@kernel
def over_current(current, c_0, c_1, c_2, c_3, c_4):
    """Torque [N m] at a current [A]."""
    return legendre(placed(current, -MOST, MOST), c_0, c_1, c_2, c_3, c_4)


@kernel
def torque(motor_current, c_0, c_1, c_2, c_3, c_4):
    """Torque on the rotor [N m]."""
    return over_current(motor_current, c_0, c_1, c_2, c_3, c_4)


GENERIC = Description(
    Effect(
        name="generic_current_torque",
        meaning="A torque of the motor depends on its current. It describes, and names no cause.",
        equation="J w' += sum c_k P_k(i / i_max)",
        source="Legendre's polynomials",
        parameters=coefficients("N m", 0.02),
        terms=(Term(torque, writes=("motor_torque",), unit="N m"),),
    ),
    axis="the current",
    unit="A",
    ends=(-MOST, MOST),
    value="a torque on the motor",
    value_unit="N m",
    law=over_current,
)
