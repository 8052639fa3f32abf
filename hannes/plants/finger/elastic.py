"""Elastic contact of a finger: a power of how deep the actuator's angle presses."""

from hannes.core.kernels.jit import kernel


@kernel
def pressed(angle, stiffness, contact_angle, exponent):
    """Force [counts] at an angle [counts] held for long; `contact_angle` in 100 counts."""
    return stiffness * max(contact_angle - 0.01 * angle, 0.0) ** exponent
