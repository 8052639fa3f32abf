"""What a fit gains, counted in the noise that is really there.

Noise is told too large where machines are noisier in simulation than on the bench: then the best
model leaves less than one per bin. So much less noise counts. What runs are told to differ in is
told by their number alone, and counts as it was told: were it less as well, twelve runs that all
started late by chance would be a delay.
"""

import numpy as np

from hannes.identification.diagnosis.linearisation import Point

QUIET = 0.7  # of the noise told, at least, where the best model leaves less: it is told too large


def noise_left(base: Point, least: float) -> float:
    """What a bin's square is by noise alone, of the least misfit of any model: 1 as it was told.

    Never below QUIET; where only repeats tell it, never below 1.
    """
    return max(QUIET if base.ground.told else 1.0, least / base.miss.size)


def lowered(base: Point, point: Point, unit: float) -> float:
    """How far a point is below the base, where a bin's square by noise is `unit`."""
    if unit >= 1.0:
        return (base.misfit - point.misfit) / unit
    return _weighed(base, unit) - _weighed(point, unit)


def _weighed(point: Point, unit: float) -> float:
    """The misfit with less noise, what runs differ in as it was."""
    from scipy.linalg import solve_triangular

    ground, found = point.ground, float(np.sum((point.ground.model.space.prior * point.x) ** 2))
    groups = ground.model.groups
    misses = np.split(point.miss, np.cumsum([group.part.size for group in groups])[:-1])
    for group, root, rows, miss in zip(groups, ground.roots, ground.restless, misses, strict=True):
        less = unit * (root @ root.T) + (1.0 - unit) / group.count * (rows.T @ rows)
        white = solve_triangular(np.linalg.cholesky(less), root @ miss, lower=True)
        found += float(white @ white)
    return found
