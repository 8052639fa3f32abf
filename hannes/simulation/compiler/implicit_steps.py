"""Runs of a machine of one angle and its speed, by steps that dry friction does not make small.

Text like entry_points.py. Dry friction that holds a machine at rest is stiff, and changes sides
within a step. Each step has two implicit stages (SDIRK2, Alexander 1977), and each is solved for
its speed by false position: a loaded machine stays where it is. The plant's first state is the
angle (or a position), the second its rate. What effects bring as states of their own follows
exponentially. Steps are fixed, so that runs change smoothly with parameters.
"""

from typing import Any

import numpy as np

# Filled in by assemble.py.
STATES, CHANNELS, OUTPUTS, MEMORY = 1, 1, 1, 1
equations: Any = None


def held_steps(times, y, p, reference, step, states):
    """Fill states (n, STATES) at `times` [s] from y, by equal steps of at most `step` [s].

    memory[0] is the step [s], so that equations may take a command that comes in for a part.
    """
    gamma = 1.0 - np.sqrt(0.5)
    work, memory = np.zeros((3, STATES)), np.zeros(MEMORY)
    c, out = np.zeros(CHANNELS), np.zeros(OUTPUTS)
    for k in range(times.size):
        if k > 0:
            parts = max(1, int(np.ceil((times[k] - times[k - 1]) / step - 1e-6)))
            h = (times[k] - times[k - 1]) / parts
            near, far, memory[0] = gamma * h, (1.0 - gamma) * h, h
            for part in range(parts):
                t, angle, speed = times[k - 1] + part * h, y[0], y[1]
                v = held_speed(t + near, near, angle, speed, y, work, p, c, reference, memory, out)
                angle, speed = angle + far * v, speed + far * (v - speed) / near
                y[1] = held_speed(t + h, near, angle, speed, y, work, p, c, reference, memory, out)
                y[0] = angle + near * y[1]
                if STATES > 2:
                    others_held(t + h, h, y, work, p, c, reference, memory, out)
        states[k] = y


def held_speed(t, h, angle, speed, y, work, p, c, reference, memory, out):
    """The speed at the end of an implicit stage; friction falls on it from either side."""
    near = speed
    f_near = speed_lacking(near, t, h, angle, speed, y, work, p, c, reference, memory, out)
    far = near - f_near
    f_far = speed_lacking(far, t, h, angle, speed, y, work, p, c, reference, memory, out)
    if f_near * f_far >= 0.0:
        return far
    found = far
    for _ in range(50):
        found = (near * f_far - far * f_near) / (f_far - f_near)
        f = speed_lacking(found, t, h, angle, speed, y, work, p, c, reference, memory, out)
        if abs(f) < 1e-7 * (1e-3 + abs(far)):
            break
        if f * f_far < 0.0:
            near, f_near = far, f_far
        else:
            f_near *= 0.5
        far, f_far = found, f
    return found


def speed_lacking(found, t, h, angle, speed, y, work, p, c, reference, memory, out):
    """By how much a speed exceeds what the rates at it lead to within h."""
    for j in range(2, STATES):
        work[0, j] = y[j]
    work[0, 0], work[0, 1] = angle + h * found, found
    equations(t, work[0], work[1], p, c, reference, memory, out)
    return found - speed - h * work[1, 1]


def others_held(t, h, y, work, p, c, reference, memory, out):
    """Further states at the end of a step: each decays as its rate changes with it."""
    equations(t, y, work[0], p, c, reference, memory, out)
    for j in range(STATES):
        work[2, j] = y[j]
    for j in range(2, STATES):
        size = 1e-6 * max(abs(y[j]), 1.0)
        work[2, j] += size
        equations(t, work[2], work[1], p, c, reference, memory, out)
        decay = h * (work[1, j] - work[0, j]) / size
        share = np.expm1(decay) / decay if abs(decay) > 1e-9 else 1.0
        work[2, j] = y[j]
        y[j] += share * h * work[0, j]
