"""Supply sag: the voltage falls while the motor draws current."""

from hannes import Effect, Parameter, Term, kernel


@kernel
def lost(duty, back_emf, supply_voltage, motor_resistance, resistance):
    """Voltage lost in the source [V]: it gives duty i, which the lower voltage lowers."""
    drawn = (duty * supply_voltage - back_emf) / (motor_resistance + resistance * duty * duty)
    return -resistance * duty * drawn


EFFECT = Effect(
    name="supply_sag",
    meaning="The supply's voltage falls while the motor draws current.",
    equation="V = V_0 - resistance duty i, i = (duty V - k w) / R",
    source="Erickson & Maksimovic (2001), a converter's mean current",
    parameters=(Parameter("resistance", 0.0, "ohm", (0.0, 3.0), "of supply and leads", off=0.0),),
    terms=(Term(lost, writes=("supply",), unit="V"),),
)
