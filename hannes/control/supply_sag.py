"""Supply sag: the bus voltage falls while current is drawn."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def sag(duty, motor_current, resistance):
    """Voltage lost in the source [V]; a drive at `duty` draws duty i from the bus."""
    return -resistance * duty * motor_current


EFFECT = Effect(
    name="supply_sag",
    meaning="The battery's voltage falls while the motor draws current.",
    equation="V_bus = V_0 - resistance duty i",
    source="Erickson & Maksimovic (2001), a converter's mean current",
    parameters=(Parameter("resistance", 0.0, "ohm", (0.0, 3.0), "of battery and leads", off=0.0),),
    terms=(Term(sag, writes=("supply",)),),
)
