"""Wires that stretch more than the base has it: knots, crimps and sheaths in series.

    1 / k = 1 / k_base + leader     (leader wire)
    1 / k = 1 / k_base + follower   (each follower wire); damping unchanged

Source: springs in series (Hooke). Range: 1 % to 130 % of the nominal wires' 15 um/N.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"leader": Size("m/N", 1.5e-7, 2e-5), "follower": Size("m/N", 1.5e-7, 2e-5)}


@compiled
def in_series(stiffness, compliance):
    """Stiffness (N/m) of a wire with a further compliance (m/N) behind it."""
    return stiffness / (1.0 + stiffness * compliance)
