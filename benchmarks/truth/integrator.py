"""SDIRK2 (Alexander 1977, gamma = 1 - 1/sqrt 2): second order, L-stable, two implicit stages.

Each stage is solved by Newton's method with a differenced Jacobian that is kept while it converges;
the result depends on it only below `TOLERANCE`. A stage that will not converge halves the step.
"""

from math import sqrt

import numpy as np

from benchmarks.truth._jit import compiled
from benchmarks.truth.motion import rates

GAMMA = 1.0 - 1.0 / sqrt(2.0)
TOLERANCE = 1e-9  # in units of SCALE
# Joint angles, their speeds, carts, their speeds, motor angle, speed, current, controller's three.
SCALE = np.repeat([1, 10, 1e-2, 0.1, 100, 300, 1, 1, 100, 1], [10, 10, 2, 2, 1, 1, 1, 1, 1, 1])


@compiled
def factor(a, pivots):
    """LU of `a` in place, rows exchanged."""
    n = a.shape[0]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        pivots[k] = best
        if best != k:
            for j in range(n):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        for i in range(k + 1, n):
            if a[i, k] != 0.0:
                a[i, k] /= a[k, k]
                for j in range(k + 1, n):
                    a[i, j] -= a[i, k] * a[k, j]


@compiled
def solve(a, pivots, b):
    """b becomes the solution."""
    n = a.shape[0]
    for k in range(n):
        best = pivots[k]
        b[k], b[best] = b[best], b[k]
    for i in range(n):
        for j in range(i):
            b[i] -= a[i, j] * b[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            b[i] -= a[i, j] * b[j]
        b[i] /= a[i, i]


@compiled
def linearise(h, y, reference, duty, is_sampled, gain, scale, work):
    """work.lu becomes the factors of I - gain df/dy at y."""
    lu, pivots, base, moved, point = work
    n = y.shape[0]
    rates(h, y, reference, duty, is_sampled, base)
    for j in range(n):
        point[:] = y
        point[j] += 1e-7 * scale[j]
        width = point[j] - y[j]
        rates(h, point, reference, duty, is_sampled, moved)
        for i in range(n):
            lu[i, j] = -gain * (moved[i] - base[i]) / width
        lu[j, j] += 1.0
    factor(lu, pivots)


@compiled
def stage(h, start, y, reference, duty, is_sampled, gain, scale, work):
    """Solves y = start + gain f(y) from the guess y. Returns (converged, Jacobian worn out)."""
    lu, pivots, base, _, point = work
    last, since = np.inf, 0
    for count in range(40):
        rates(h, y, reference, duty, is_sampled, base)
        for i in range(y.shape[0]):
            point[i] = start[i] + gain * base[i] - y[i]
        solve(lu, pivots, point)
        size = 0.0
        for i in range(y.shape[0]):
            size = max(size, abs(point[i]) / scale[i])
            y[i] += point[i]
        if size < TOLERANCE:
            return True, count > 5
        since += 1
        if since > 1 and not size < 0.3 * last:  # also where size is not a number
            if not np.isfinite(size):
                return False, True
            linearise(h, y, reference, duty, is_sampled, gain, scale, work)
            since = 0
        last = size
    return False, True


@compiled
def step(h, y, slope, references, duty, is_sampled, size, scale, work, new):
    """One step of `size` from y; `slope` (f at y) guesses the first stage and is renewed.

    references (rad): at the two stages' times. Returns (converged, Jacobian worn out).
    """
    gain = GAMMA * size
    new[:] = y + gain * slope
    good, worn = stage(h, y, new, references[0], duty, is_sampled, gain, scale, work)
    if not good:
        return False, True
    first = (new - y) / gain
    start = y + size * (1.0 - GAMMA) * first
    new[:] = start + gain * first
    good, also = stage(h, start, new, references[1], duty, is_sampled, gain, scale, work)
    if good:
        slope[:] = (new - start) / gain
        y[:] = new
    return good, worn or also
