"""The two nested PIDs: position outside, current inside, both at the motor side."""

from hannes.core.kernels.jit import kernel
from hannes.core.kernels.smooth_switches import limited
from hannes.core.parameter import Parameter, group

PARAMETERS = (
    group(
        "position_pid",
        Parameter("proportional", 0.0358, "A/rad", (1e-6, 100), "on the motor-side error"),
        Parameter("integral", 0.0, "A/(rad s)", (0, 1e4), "on the motor-side error"),
        Parameter("derivative", 1.95e-3, "A s/rad", (0, 10), "on the measured motor speed"),
        Parameter("filter", 2.5e-3, "s", (1e-5, 1), "of the measured speed, continuous form"),
        Parameter("limit", 4.0, "A", (0.01, 100), "of the current reference"),
    )
    + group(
        "current_pid",
        Parameter("proportional", 1.0, "V/A", (0.001, 1e3), "on the current error"),
        Parameter("integral", 900.0, "V/(A s)", (0, 1e6), "on the current error"),
        Parameter("derivative", 0.0, "V s/A", (0, 1), "on the measured current"),
        Parameter("filter", 1e-3, "s", (1e-5, 1), "of the current's derivative"),
    )
    + group(
        "controller",
        Parameter("sampled", 0.0, "1", (0, 1), "1: firmware at its period, 0: continuous"),
        Parameter("period", 1e-3, "s", (1e-5, 0.1), "of the sampled controller"),
        Parameter("speed_weight", 0.4, "1", (0.001, 1), "of the sampled speed's one-pole filter"),
        Parameter("current_step", 0.0, "A", (0, 1), "resolution of the sampled current"),
        Parameter("current_noise", 0.0, "A", (0, 1), "of every sample of it, standard deviation"),
        Parameter("noise_bandwidth", 0.0, "Hz", (0, 1e5), "of that noise; 0: it is white"),
        Parameter("noise_seed", 0.0, "1", (0, 1e6), "whole number: which noise that is"),
    )
)


@kernel
def pid(error, integral, derivative, proportional_gain, derivative_gain):
    """Sum of the three terms; `derivative` is that of the measured value, `integral` ready."""
    return proportional_gain * error + integral - derivative_gain * derivative


@kernel
def integral_rate(error, wanted, given, proportional_gain, integral_gain):
    """Rate of the integral term; anti-windup takes back what the limit cut off."""
    return integral_gain * (error + (given - wanted) / proportional_gain)


@kernel
def saturated(wanted, limit):
    """What the limit lets through, its corner rounded over 2 %."""
    return limited(wanted, limit)
