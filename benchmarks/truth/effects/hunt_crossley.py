"""Hunt-Crossley contact: an object that stiffens with depth and damps in proportion to it.

    F_n = k x (x / 1 mm)^exponent (1 + dissipation x') + beta x' ramp(x)

x: depth; k, beta: of equation 3, which is the case exponent = dissipation = 0. k keeps its meaning
at 1 mm of depth. Hunt and Crossley's own form has power 1 + exponent and lambda = k dissipation.
Source: Hunt & Crossley (1975). Range: exponent 0.05 to 0.8 (Hertz: 0.5), dissipation 0.1 to 3 s/m.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"exponent": Size("1", 0.05, 0.8), "dissipation": Size("s/m", 0.1, 3.0)}
DEPTH = 1e-3  # m


@compiled
def elastic(depth, rate, stiffness, exponent, dissipation):
    """Normal force (N) without equation 3's own damping; depth (m) is positive."""
    force = stiffness * depth * (1.0 + dissipation * rate)
    return force * (depth / DEPTH) ** exponent if exponent != 0.0 else force
