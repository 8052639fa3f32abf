"""Magnetic encoder at the output shaft: continuous for the model, counted for firmware."""

import math

from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter, group

PARAMETERS = group(
    "encoder", Parameter("bits", 12.0, "1", (4, 32), "counts per output turn = 2^bits")
)


@kernel
def quantised(angle, bits):
    """Angle as the encoder counts it [rad]; counts on over several turns."""
    step = 2.0 * math.pi / 2.0**bits
    return step * math.floor(angle / step + 0.5)
