"""Generic disturbance: an error of the force sensor, over its own value."""

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import legendre, placed

HARDEST = 80.0  # N, of one finger


@kernel
def over_force(force, c_1, c_2, c_3, c_4):
    """Error of the reading [N] at a finger's force [N]; none where it does not touch."""
    found = legendre(placed(force, 0.0, HARDEST), 0.0, c_1, c_2, c_3, c_4)
    return found + c_1 - c_2 + c_3 - c_4


@kernel
def grip(logged_force, c_1, c_2, c_3, c_4):
    """Of a finger's normal forces [N]."""
    return over_force(logged_force, c_1, c_2, c_3, c_4)


@kernel
def face(logged_sensor, c_1, c_2, c_3, c_4):
    """Of a finger's push on the dynamometer's sensing face [N]."""
    return over_force(logged_sensor, c_1, c_2, c_3, c_4)


GENERIC = Description(
    Effect(
        name="generic_force_error",
        meaning="The force's reading is off by its own value. It describes, and names no cause.",
        equation="logged force and sensor += sum c_k (P_k(2 F / F_max - 1) - P_k(-1))",
        source="Legendre's polynomials",
        parameters=coefficients("N", 20.0)[1:],
        terms=(
            Term(grip, writes=("logged_force",), unit="N"),
            Term(face, writes=("logged_sensor",), unit="N"),
        ),
    ),
    axis="one finger's force",
    unit="N",
    ends=(0.0, HARDEST),
    value="the force sensor's error",
    value_unit="N",
    law=over_force,
)
