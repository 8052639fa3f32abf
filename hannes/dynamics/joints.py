"""MCP and PIP joints: re-opening springs, end stops, moment arms, friction magnitudes.

The paper re-opens the hand by pulleys and wires; joint springs with preload stand in for them.
"""

from hannes.core.kernels.jit import kernel
from hannes.core.kernels.smooth_switches import one_sided
from hannes.core.parameter import Parameter, group
from hannes.dynamics.friction import friction_parameters


def _joint(name, arm, spring, preload, friction, row):
    return group(
        name,
        Parameter("moment_arm", arm, "m", (1e-4, 0.05), "of the flexor wire"),
        Parameter("spring_stiffness", spring, "N m/rad", (0, 1), "re-opening spring"),
        Parameter("spring_preload", preload, "N m", (0, 1), "re-opening torque at rest"),
        Parameter("stop_stiffness", 6.0, "N m/rad", (0.1, 1e4), "both end stops"),
        Parameter("stop_damping", 0.02, "N m s/rad", (0, 10), "both end stops"),
        Parameter("stop_onset", 1e-3, "rad", (1e-6, 0.1), "depth to full stop damping"),
        *friction_parameters("N m", "rad/s", friction, f"magnitude from Table I, {row}"),
    )


RPM_100 = 10.471975511965978

PARAMETERS = _joint(
    "mcp", 0.010, 24.7e-3, 27.7e-3, (13.9e-3, 10.7e-3, RPM_100, 1.07e-3), "MCP"
) + _joint("pip", 0.0045, 22.2e-3, 9.3e-3, (10.7e-3, 2.1e-3, RPM_100, 1.07e-3), "PIP")


@kernel
def spring_torque(angle, rest, stiffness, preload):
    """Re-opening torque [N m], positive towards opening: preload + k (q - q_rest)."""
    return preload + stiffness * (angle - rest)


@kernel
def stop_torque(angle, speed, low, high, preload, stiffness, damping, onset):
    """Torque of both end stops [N m], positive towards closing.

    The lower stop carries the preload at `low`, so the open hand rests exactly there.
    """
    lower = one_sided(stiffness, damping, low + preload / stiffness - angle, -speed, onset)
    upper = one_sided(stiffness, damping, angle - high, speed, onset)
    return lower - upper
