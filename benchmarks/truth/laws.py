"""Force laws of one variable: friction after equations 1-2, wires, stops, drive friction."""

from math import exp, sqrt, tanh

from benchmarks.truth._jit import compiled


@compiled
def held(start, gain, a, b):
    """z after an implicit part-step z = start + gain (a - b z), b >= 0; `start` at gain 0."""
    return (start + gain * a) / (1.0 + gain * b)


@compiled
def onset(stretch, width):
    """Smoothstep from 0 at `stretch` 0 to 1 at `width`: no damping before there is contact."""
    u = min(max(stretch / width, 0.0), 1.0)
    return u * u * (3.0 - 2.0 * u)


@compiled
def one_sided(stretch, rate, stiffness, damping, width):
    """Push (N or N m) of a spring-damper that never pulls; nil without stretch."""
    if stretch <= 0.0:
        return 0.0
    return max(0.0, stiffness * stretch + damping * rate * onset(stretch, width))


@compiled
def friction(speed, breakaway, coulomb, breakaway_speed, viscous):
    """Equations 1 and 2 of the paper: the part beyond Coulomb peaks at the breakaway speed."""
    ratio = speed / (breakaway_speed * sqrt(2.0))
    peak = sqrt(2.0 * exp(1.0)) * (breakaway - coulomb) * exp(-ratio * ratio) * ratio
    return peak + coulomb * tanh(speed / (0.1 * breakaway_speed)) + viscous * speed


@compiled
def drive_friction(speed, load, dry, asymmetry, load_loss, speed_scale, viscous):
    """Torque (N m) against the motor: dry (1 + a closing, 1 - a opening), by load, viscous."""
    way = tanh(speed / speed_scale)
    return dry * way * (1.0 + asymmetry * way) + load_loss * abs(load) * way + viscous * speed


@compiled
def spring_and_stops(angle, speed, limits, spring, stop):
    """Torque (N m, closing positive) of a joint's return spring and its two stops.

    limits: rest and upper angle; spring: stiffness, preload; stop: stiffness, damping, onset (rad).
    The lower stop starts where it carries the preload at the rest angle: rest is an equilibrium.
    """
    rest, upper = limits
    stiffness, preload = spring
    low = one_sided(rest + preload / stop[0] - angle, -speed, stop[0], stop[1], stop[2])
    high = one_sided(angle - upper, speed, stop[0], stop[1], stop[2])
    return low - high - preload - stiffness * (angle - rest)
