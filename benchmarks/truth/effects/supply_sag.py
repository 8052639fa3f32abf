"""Supply sag: a battery's and its leads' resistance lowers the bus under load.

    V_bus = V_0 - resistance (duty i);  V_motor = duty V_bus

duty i: mean current drawn from the bus; the controllers go on dividing by V_0.
Source: Thevenin equivalent of the battery. Range: leads alone (20 mohm) to a worn cell (1.5 ohm).
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"resistance": Size("ohm", 0.02, 1.5)}


@compiled
def bus(h, duty, current):
    """Voltage (V) of the bus while the winding carries `current` (A)."""
    return h.supply_voltage - h.supply_sag_resistance * duty * current
