"""Sampled cascade of a position and a speed loop, as the controller of the EMPS axis runs it."""

from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter, group

EMPS = "EMPS data set, its controller"

PARAMETERS = group(
    "cascade",
    Parameter("position_gain", 160.18, "1/s", (0.1, 1e4), "asked speed per error, k_p", EMPS),
    Parameter("speed_gain", 243.45, "V s/m", (0.1, 1e5), "volts per speed error, k_v", EMPS),
    Parameter("limit", 10.0, "V", (0.1, 1e3), "of the controller's output", EMPS),
    Parameter("period", 1e-3, "s", (1e-5, 0.1), "of the sampled controller", EMPS),
)


@kernel
def mean_difference(now, before, earlier, period):
    """Speed [m/s]: backward difference of the 2-tap mean of three positions [m]."""
    return (0.5 * (now + before) - 0.5 * (before + earlier)) / period


@kernel
def cascade(target, position, speed, position_gain, speed_gain, limit):
    """u = k_v (k_p (target - position) - speed), cut off at +-limit [V]."""
    wanted = speed_gain * (position_gain * (target - position) - speed)
    return min(max(wanted, -limit), limit)
