"""Dead time of the H-bridge, during which the current's direction sets the voltage.

    V_motor = duty V_bus - share V_0 tanh(i / i_r),  i_r = 20 mA

share: twice the dead time over the switching period. Beyond the ripple i_r the freewheeling diodes
put the bus against the current; within it either diode leads for a part of the period.
Source: Mohan, Undeland & Robbins (2003). Range: 0.2 us at 20 kHz (0.8 %) to 2 us (8 %).
"""

from math import tanh

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"share": Size("1", 0.008, 0.08)}
RIPPLE = 0.02  # A


@compiled
def volts_lost(h, current):
    """Voltage (V) that a current (A) takes while the bridge is off."""
    return h.bridge_dead_time_share * h.supply_voltage * tanh(current / RIPPLE)
