"""Generic disturbance: the leader's tension eases while it is borne."""

import math

from hannes.core.description import Description
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter


@kernel
def kept(time, rate):
    """Share of a tension that is left after a time [s] of constant stretch."""
    return math.exp(-rate * time)


@kernel
def easing(leader_tension, eased, rate):
    """Tension lost to earlier load [N], and the rate at which it is lost [N/s]."""
    lost = min(leader_tension, eased)
    return -lost, rate * (leader_tension - lost)


GENERIC = Description(
    Effect(
        name="generic_easing",
        meaning="The leader's tension eases while it is borne. It describes, and names no cause.",
        equation="T_L -= min(e, T_L), e' = rate max(T_L - e, 0)",
        source="Maxwell (1867)",
        parameters=(Parameter("rate", 0.0, "1/s", (0.0, 3.0), "of the easing", "choice", off=0.0),),
        terms=(Term(easing, writes=("leader_tension",), states=("eased",), unit="N"),),
        states=(Slot("eased", "N", "tension lost", tolerance=1e-4),),
    ),
    axis="the time under load",
    unit="s",
    ends=(0.0, 1.0),
    value="the share that is kept of the leader's tension",
    value_unit="1",
    law=kept,
)
