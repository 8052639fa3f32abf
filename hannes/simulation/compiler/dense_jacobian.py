"""Jacobian and solution of any plant without regard to its shape: dense differences and LU.

Text of the same kind as arrowhead.py, for plants and effects whose shape is not known.
"""

from typing import Any

import numpy as np

from hannes.simulation.rodas.linear_algebra import copy_to, factor, substitute

equations: Any = None  # the plant's own, filled in by assemble.py
CHANNELS, OUTPUTS = 1, 1  # sizes and steps of the plant come from the assembly
steps = np.full(31, 1e-3)


def slope(t, y, dy, data):
    """Fill dy with f(t, y)."""
    p, reference, hold, c, out, _, _ = data[0]
    equations(t, y, dy, p, c, reference, hold, out)


def linearise(t, y, rates, drift, data):
    """Keep df/dy, one column a state; fill drift with df/dt."""
    p, reference, hold, c, out, dy, moved = data[0]
    matrix = data[1]
    copy_to(moved, y)
    for j in range(y.size):
        moved[j] += 1e-7 * max(abs(y[j]), steps[j])
        equations(t, moved, dy, p, c, reference, hold, out)
        for i in range(y.size):
            matrix[i, j] = (dy[i] - rates[i]) / (moved[j] - y[j])
        moved[j] = y[j]
    later = t + 1e-7 * max(1.0, abs(t))
    equations(later, y, dy, p, c, reference, hold, out)
    for i in range(y.size):
        drift[i] = (dy[i] - rates[i]) / (later - t)


def decompose(shift, data):
    """Factor shift - df/dy."""
    factor(data[1], shift, data[2], data[3])


def resolve(b, data):
    """Replace b by the solution x of (shift - df/dy) x = b."""
    substitute(data[2], data[3], b)


def mark(y, data):
    """Kinks are not known."""


def crossing(y, data):
    """None is known."""
    return 2.0


def gather(data, columns):
    """Copy df/dy."""
    for i in range(columns.shape[0]):
        copy_to(columns[i], data[1][i])


def workspace(y, p, reference, hold):
    """Everything that these functions pass around."""
    n = y.size
    scratch = (p, reference, hold, np.zeros(CHANNELS), np.zeros(OUTPUTS), np.zeros(n), np.zeros(n))
    return (scratch, np.zeros((n, n)), np.zeros((n, n)), np.zeros(n, np.int64))
