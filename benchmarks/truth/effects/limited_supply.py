"""Outside the catalogue: a bench supply that gives no more than the current it is set to.

    V_bus -= min(15 ohm max(0, I - 1 / inverse_current), 0.9 V_0),  I = duty i

I: current drawn from the bus, 2 A at the peak of the paper's grasp and 0.2 A in its free closure;
the controllers go on dividing by V_0. Source: constant-current mode of laboratory supplies, whose
output capacitor makes the knee soft. Range: limits from 1.7 A (0.6) to 0.33 A (3).
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"inverse_current": Size("1/A", 0.6, 3.0)}
KNEE = 15.0  # ohm
MOST = 0.9  # of the supply's voltage


@compiled
def bus_drop(h, duty, current):
    """Voltage (V) that the bus lacks at a duty and a winding's current (A)."""
    if h.limited_supply_inverse_current == 0.0:
        return 0.0
    over = duty * current - 1.0 / h.limited_supply_inverse_current
    return min(KNEE * max(0.0, over), MOST * h.supply_voltage)
