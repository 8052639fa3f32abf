"""Outside the catalogue: a force sensor that reads less and less of what is added to its load.

    F_measured = F / (1 + inverse_force |F|)

for both force channels, before their amplifier; the hand itself meets nothing of it. Source:
resistive force sensors, whose conductance bends with load (data sheets). Range: 3 % to 50 % missing
at 100 N.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"inverse_force": Size("1/N", 3e-4, 1e-2)}


@compiled
def seen(h, force):
    """Force (N) that the sensor shows under a force (N)."""
    return force / (1.0 + h.force_saturation_inverse_force * abs(force))
