"""PWM drive: a duty between -1 and 1 of the supply."""

from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter, group

PARAMETERS = group(
    "supply", Parameter("voltage", 12.0, "V", (1, 60), "of the bus", "paper, section II")
)


@kernel
def drive_voltage(duty, supply):
    """Mean voltage at the motor [V]: duty times supply."""
    return duty * supply
