"""Wrong gravity: another load on the shaft than stated, or a servo mounted at another angle."""

import math

from hannes import Effect, Parameter, Term, kernel


@kernel
def further(shaft_position, gear_ratio, sine, cosine):
    """Torque of gravity beyond the stated one, at the motor [N m]."""
    return (sine * math.sin(shaft_position) + cosine * math.cos(shaft_position)) / gear_ratio


EFFECT = Effect(
    name="wrong_gravity",
    meaning="The load weighs otherwise than stated, or hangs at another angle.",
    equation="T_gravity += sine sin(q) + cosine cos(q)",
    source="Craig (2005), gravity in the dynamics of a link",
    parameters=(
        Parameter("sine", 0.0, "N m", (-1.0, 1.0), "of the further torque", off=0.0),
        Parameter("cosine", 0.0, "N m", (-1.0, 1.0), "likewise", off=0.0),
    ),
    terms=(Term(further, writes=("load",), unit="N m"),),
)
