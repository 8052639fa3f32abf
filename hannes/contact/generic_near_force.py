"""Generic disturbance: objects push before a bare finger would touch them, over the distance."""

from hannes.core.description import Description
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter

NEAR = 4e-3  # m, from which a phalanx is pushed


@kernel
def over_depth(depth, c_1, c_2, c_3, c_4):
    """Normal force [N] at a depth of the finger in the object [m], which is negative before.

    It never pulls, and stays as it is from the touch on. Each power begins three times nearer.
    """
    x = min(max(1.0 + depth / NEAR, 0.0), 1.0)
    third = x * x * x
    ninth = third * third * third
    return max(0.0, c_1 * x + c_2 * third + c_3 * ninth + c_4 * ninth * ninth * ninth)


@kernel
def push(penetration, c_1, c_2, c_3, c_4):
    """Added to the normal force of a phalanx [N]."""
    return over_depth(penetration, c_1, c_2, c_3, c_4)


GENERIC = Description(
    Effect(
        name="generic_near_force",
        meaning="Objects push each phalanx before and beyond where it should touch them. It "
        "describes, and names no cause.",
        equation="F_n += max(0, sum c_k (1 + x / near)^(3^(k - 1))), constant for x > 0",
        source="powers of the distance",
        parameters=tuple(
            Parameter(
                f"c_{k}", 0.0, "N", (-20.0, 20.0), f"of power {3 ** (k - 1)}", "choice", off=0.0
            )
            for k in range(1, 5)
        ),
        terms=(Term(push, writes=("normal_force",), unit="N"),),
    ),
    axis="the depth of a phalanx in the object",
    unit="m",
    ends=(-NEAR, 0.0),
    value="a further normal force",
    value_unit="N",
    law=over_depth,
)
