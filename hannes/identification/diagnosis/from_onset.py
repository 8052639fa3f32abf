"""Sizes of a fault from where it begins to act, a step apart to the end of its range, or 60 steps.

A stop that is moved does nothing until the joint comes to it. Each further step then changes much:
the valley of the right size is a step wide, and sizes further apart miss it.
"""

from collections.abc import Iterator

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.score_test import amplitude_names
from hannes.identification.diagnosis.sizes_looked_at import Looked, left_at
from hannes.identification.diagnosis.tuning import ONSET


def looked_at_from_onset(nominal: Linearisation, name: str, looked: Looked) -> Looked:
    """Points with a fault at sizes from its onset on, and what each leaves, beside some known.

    looked: at sizes further apart. Unchanged where the fault acts from the first step on.
    """
    rows, left = looked
    for row in _ends(nominal, name):
        more = _from_onset(nominal, name, row)
        rows, left = np.vstack([rows, more]), np.append(left, left_at(nominal, name, more))
    return rows, left


def _ends(nominal: Linearisation, name: str) -> Iterator[np.ndarray]:
    """Changes of a point that take each amplitude to each end of its range, shape (size,)."""
    space = nominal.space
    for place in (space.place(each) for each in amplitude_names(space.effects[name])):
        for end in (space.low[place], space.high[place]):
            far = float(np.clip(end - nominal.x[place], -ONSET.farthest, ONSET.farthest))
            if abs(far) > ONSET.later:
                yield far * (np.arange(space.size) == place)


def _from_onset(nominal: Linearisation, name: str, end: np.ndarray) -> np.ndarray:
    """Points a step apart from where the fault acts to the end, shape (m, size); none without."""
    far = float(np.abs(end).max())
    silent, acting = ONSET.later, far
    sizes = np.array([0.0, silent, acting])
    without, *there = left_at(nominal, name, nominal.x + sizes[:, np.newaxis] / far * end)
    acts = [abs(each - without) > ONSET.acts for each in there]
    if acts[0] or not acts[1]:
        return np.zeros((0, end.size))
    while acting - silent > 1.0:
        middle = 0.5 * (silent + acting)
        (here,) = left_at(nominal, name, (nominal.x + middle / far * end)[np.newaxis])
        moved = abs(here - without) > ONSET.acts
        silent, acting = (silent, middle) if moved else (middle, acting)
    sizes = np.append(np.arange(acting, far, 1.0), far)
    return nominal.x + sizes[:, np.newaxis] / far * end
