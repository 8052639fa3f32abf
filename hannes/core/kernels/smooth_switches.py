"""Smooth switches: how a one-sided force begins and how a limit is reached.

Every switch is at least continuous with a named width, so that an adaptive integrator never
meets a hidden jump.
"""

from hannes.core.kernels.jit import kernel


@kernel
def smoothstep(x):
    """0 below 0, 1 above 1, 3 x^2 - 2 x^3 between; dimensionless."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@kernel
def one_sided(stiffness, damping, depth, rate, onset):
    """Spring-damper that only pushes: max(0, k s + c s' ramp(s / onset)), zero for s <= 0.

    `stiffness` [N/m], `damping` [N s/m], `depth` s [m], `rate` s' [m/s], `onset` [m]; the same
    with N m and rad. The ramp keeps a wire from pulling before it is taut.
    """
    force = stiffness * max(depth, 0.0) + damping * rate * smoothstep(depth / onset)
    return max(force, 0.0)


@kernel
def limited(x, limit):
    """Clip `x` to +-`limit`, rounding the corner over the last 2 % on either side."""
    width = 0.02 * limit
    size = abs(x)
    if size <= limit - width:
        return x
    sign = 1.0 if x > 0.0 else -1.0
    if size >= limit + width:
        return sign * limit
    over = size - (limit - width)
    return sign * (size - over * over / (4.0 * width))


@kernel
def one_sided_derivatives(stiffness, damping, depth, rate, onset):
    """Derivatives of `one_sided` by depth and by rate.

    At the kink, and 1e-4 `onset` before it, those of the pushing side: a wire that is just taut at
    rest would else come and go with the last digit, unnoticed by a long step.
    """
    x = min(max(depth / onset, 0.0), 1.0)
    ramp = x * x * (3.0 - 2.0 * x)
    force = stiffness * max(depth, 0.0) + damping * rate * ramp
    pushes = 1.0 if min(depth + 1e-4 * onset, force) >= 0.0 else 0.0
    by_depth = stiffness + damping * rate * 6.0 * x * (1.0 - x) / onset
    return pushes * by_depth, pushes * damping * ramp


@kernel
def limited_slope(x, limit):
    """Derivative of `limited`."""
    if limit <= 0.0:
        return 0.0
    width = 0.02 * limit
    return 0.5 * min(max((limit + width - abs(x)) / width, 0.0), 2.0)
