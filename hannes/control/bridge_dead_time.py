"""Dead time of the H-bridge: while both switches are off, the current itself sets the voltage.

Each switching period loses twice the dead time, and the winding then sees the bus voltage against
its current. A current that is smaller than its own ripple passes zero within the period, and what
is lost one way comes back the other.
"""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import soft_sign
from hannes.core.parameter import Parameter

RIPPLE = 0.02  # A, current within which the loss changes its sign; a choice


@kernel
def blanked(motor_current, supply_voltage, share):
    """Voltage that the current takes while both switches are off [V]."""
    return -share * supply_voltage * soft_sign(motor_current / RIPPLE)


EFFECT = Effect(
    name="bridge_dead_time",
    meaning="The drive pauses at every switching, and the current lowers the voltage.",
    equation="V_motor -= share V_0 tanh(i / 20 mA)",
    source="Mohan, Undeland & Robbins (2003), blanking time of bridges",
    parameters=(
        Parameter("share", 0.0, "1", (0.0, 0.2), "dead time in a switching period", off=0.0),
    ),
    terms=(Term(blanked, writes=("voltage",)),),
)
