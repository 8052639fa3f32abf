"""The two carts on their linear guides, which share the leader's pull among the fingers."""

from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter, group
from hannes.dynamics.friction import friction_parameters

PARAMETERS = group(
    "cart",
    Parameter("mass", 0.010, "kg", (1e-4, 1), "of each cart with its pulleys"),
    *friction_parameters(
        "N", "m/s", (2e-2, 1e-2, 0.010, 1.0), "magnitude from Table I, linear guide"
    ),
)


@kernel
def cart_rate(leader_pull, follower_pull, friction, mass):
    """m_c x'' = 2 T_L - 2 T_F - F(x'): returns x'' [m/s2]; pulls are tensions [N]."""
    return (2.0 * leader_pull - 2.0 * follower_pull - friction) / mass
