"""Outputs of the model at states that were kept; text like entry_points.py, for whole equations.

The equations that the integrator runs are without outputs, so that these are a module apart.
"""

from typing import Any

import numpy as np

# Filled in by assemble.py; `equations` as output_slice.py leaves it.
STATES, CHANNELS, OUTPUTS, STATEMENTS = 1, 1, 1, 1
equations: Any = None


def observe(times, states, p, reference, memories):
    """Outputs at `states` (n, states), shape (n, outputs)."""
    states, memories = np.ascontiguousarray(states), np.ascontiguousarray(memories)
    rows = np.zeros((times.size, OUTPUTS))
    fill_outputs(times, states, p, reference, memories, np.ones(STATEMENTS, np.bool_), rows)
    return rows


def fill_outputs(times, states, p, reference, memories, needed, rows):
    """The same into the first rows of `rows`, by statements that are `needed` (output_slice.py)."""
    dy, c = np.zeros(STATES), np.zeros(CHANNELS)
    for k in range(times.size):
        for i in range(OUTPUTS):
            rows[k, i] = 0.0
        equations(times[k], states[k], dy, p, c, reference, memories[k], rows[k], needed)
