"""Leader and follower wires: elastic, damped, and never pushing."""

from hannes.core.kernels.jit import kernel
from hannes.core.kernels.smooth_switches import one_sided
from hannes.core.parameter import Parameter, group

PARAMETERS = (
    group(
        "leader",
        Parameter("stiffness", 6.7e4, "N/m", (1e3, 1e7), "of the whole leader wire"),
        Parameter("damping", 30.0, "N s/m", (0, 1e4), "of the whole leader wire"),
    )
    + group(
        "follower",
        Parameter("stiffness", 6.45e4, "N/m", (1e3, 1e7), "of each follower wire"),
        Parameter("damping", 20.0, "N s/m", (0, 1e4), "of each follower wire"),
    )
    + group("wires", Parameter("onset", 20e-6, "m", (1e-7, 1e-3), "stretch to full damping"))
)


@kernel
def leader_stretch(wound, cart_a, cart_b, thumb, slack):
    """Stretch of the leader [m]: r_p th/N - slack - (2 x_A + 2 x_B + l_thumb); or its rate."""
    return wound - slack - (2.0 * cart_a + 2.0 * cart_b + thumb)


@kernel
def follower_stretch(cart, first_finger, second_finger):
    """Stretch of a follower [m]: 2 x_c - (l_f1 + l_f2); or its rate [m/s]."""
    return 2.0 * cart - (first_finger + second_finger)


@kernel
def tension(stretch, rate, stiffness, damping, onset):
    """Wire tension [N], zero while slack; stretch [m], rate [m/s]."""
    return one_sided(stiffness, damping, stretch, rate, onset)
