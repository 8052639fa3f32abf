"""Winding heating: resistance rises, the magnets weaken; constant within a run of seconds.

    R = R_0 (1 + 0.00393 rise),  k_t = k_e = k_t0 (1 - 0.0011 rise)

rise: temperature above that of the nominal values. Source: temperature coefficients of copper (IEC
60028) and of sintered NdFeB's remanence. A grasp's own heat (some 4 J) warms the winding by about
1 K: left out. Range: 5 K to 100 K (class B insulation).
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"rise": Size("K", 5.0, 100.0)}
COPPER, MAGNET = 3.93e-3, -1.1e-3  # 1/K


@compiled
def resistance(h):
    """Of the warm winding (ohm)."""
    return h.motor_resistance * (1.0 + COPPER * h.winding_heating_rise)


@compiled
def torque_constant(h):
    """Of the warm motor (N m/A, V s/rad)."""
    return h.motor_torque_constant * (1.0 + MAGNET * h.winding_heating_rise)
