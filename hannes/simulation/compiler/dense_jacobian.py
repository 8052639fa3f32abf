"""Jacobian and solution of any plant without regard to its shape: dense differences and LU.

Text of the same kind as arrowhead.py, for plants and effects whose shape is not known.
"""

from typing import Any

import numpy as np

from hannes.core.kernels.pointers import numbers_at
from hannes.simulation.rodas.linear_algebra import copy_to, factor, substitute

equations: Any = None  # the plant's own, filled in by assemble.py
CHANNELS, OUTPUTS = 1, 1  # sizes and steps of the plant come from the assembly
steps = np.full(31, 1e-3)

# What these functions pass around in the workspace, beside what any plant's do.
FIELDS = {"matrix": "(STATES, STATES)", "factors": "(STATES, STATES)", "exchanges": "(STATES,)"}


def slope(t, y, dy, data):
    """Fill dy with f(t, y)."""
    reference = numbers_at(data.reference[0], (data.reference[1], data.reference[2]))
    equations(t, y, dy, data.p, data.c, reference, data.memory, data.out)


def linearise(t, y, rates, drift, data):
    """Keep df/dy, one column a state; fill drift with df/dt."""
    p, memory, c, out, dy, moved = data.p, data.memory, data.c, data.out, data.dy, data.moved
    reference = numbers_at(data.reference[0], (data.reference[1], data.reference[2]))
    matrix = data.matrix
    copy_to(moved, y)
    for j in range(y.size):
        moved[j] += 1e-7 * max(abs(y[j]), steps[j])
        equations(t, moved, dy, p, c, reference, memory, out)
        for i in range(y.size):
            matrix[i, j] = (dy[i] - rates[i]) / (moved[j] - y[j])
        moved[j] = y[j]
    later = t + 1e-7 * max(1.0, abs(t))
    equations(later, y, dy, p, c, reference, memory, out)
    for i in range(y.size):
        drift[i] = (dy[i] - rates[i]) / (later - t)


def decompose(shift, data):
    """Factor shift - df/dy."""
    factor(data.matrix, shift, data.factors, data.exchanges)


def resolve(b, data):
    """Replace b by the solution x of (shift - df/dy) x = b."""
    substitute(data.factors, data.exchanges, b)


def mark(y, data):
    """Kinks are not known."""


def crossing(y, data):
    """None is known."""
    return 2.0


def gather(data, columns):
    """Copy df/dy."""
    for i in range(columns.shape[0]):
        copy_to(columns[i], data.matrix[i])
