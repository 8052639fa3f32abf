"""Command lag: the firmware smooths what it is asked for, so that no command comes as a jump."""

from hannes import Effect, Parameter, Slot, Term, kernel

SHORTEST = 1e-4  # s


@kernel
def smooth(command, first_command, smoothed, time):
    """Where the controller steers to beside the command [rad], and the smoothed one's rate."""
    behind = first_command + smoothed - command
    if time < SHORTEST:
        return 0.0 * behind, -behind / SHORTEST
    return behind, -behind / time


EFFECT = Effect(
    name="command_lag",
    meaning="The firmware smooths its commands before it steers to them.",
    equation="time r' = command - r, in place of the command",
    source="Astrom & Murray (2008), a set point through a first-order filter",
    parameters=(Parameter("time", 0.0, "s", (0.0, 0.3), "of the filter", off=0.0),),
    terms=(Term(smooth, writes=("aside",), states=("smoothed",)),),
    states=(Slot("smoothed", "rad", "command less the first one", tolerance=1e-3),),
)
