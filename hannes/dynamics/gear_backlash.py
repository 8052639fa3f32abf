"""Gear backlash: play between the reducer and the shaft of pulley and encoder.

While the wire is taut it holds the shaft against one face, and the play is nearly invisible: it
shows as a short free run of the motor whenever the hand starts from rest, and as nothing at all
in position, for the encoder sits behind the play. The shaft is without inertia; at rest it is in
the middle. Exact as long as the wire is taut where the shaft is turned; with a slack wire the
shaft's own friction decides, and here it stays with the face that closes the hand.
"""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.smooth_switches import limited
from hannes.core.parameter import Parameter


@kernel
def lost_turn(motor_angle, gear_ratio, gap):
    """What the shaft lacks of the reducer's turn: th/N clipped to +-gap/2, negated [rad]."""
    return -limited(motor_angle / gear_ratio, 0.5 * gap)


@kernel
def lost_wire(motor_angle, gear_ratio, gear_pulley_radius, gap):
    """Wire that is not wound for it [m]."""
    return gear_pulley_radius * limited(motor_angle / gear_ratio, 0.5 * gap)


EFFECT = Effect(
    name="gear_backlash",
    meaning="The reducer has play: the motor turns a little before pulley and encoder do.",
    equation="phi = th/N - clip(th/N, -gap/2, gap/2), of pulley and encoder",
    source="Nordin & Gutman (2002), dead-zone model of backlash",
    parameters=(Parameter("gap", 0.0, "rad", (0.0, 0.2), "whole play, output side", off=0.0),),
    terms=(
        Term(lost_turn, writes=("shaft_position",)),
        Term(lost_wire, writes=("slack",)),
    ),
)
