"""What a fit gains, counted in the noise that is really there.

Noise is told too large where machines are noisier in simulation than on the bench: then the best
model leaves less than one per bin. So much less noise counts. What runs are told to differ in is
told by their number alone, and counts as it was told: were it less as well, twelve runs that all
started late by chance would be a delay.
"""

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.tuning import NOISE


def estimated_variance_factor(baseline: Linearisation, least: float) -> float:
    """What a bin's square is by noise alone, of the least misfit of any model: 1 as it was told.

    Never below QUIET; where only repeats tell it, never below 1.
    """
    return max(
        NOISE.least_variance_factor if baseline.noise.simulated_noise else 1.0,
        least / baseline.residual.size,
    )


def chi2_reduction(baseline: Linearisation, point: Linearisation, variance_factor: float) -> float:
    """How far a point is below the base, where a bin's square by noise is `variance_factor`."""
    if variance_factor >= 1.0:
        return (baseline.chi2 - point.chi2) / variance_factor
    return _weighed(baseline, variance_factor) - _weighed(point, variance_factor)


def _weighed(point: Linearisation, variance_factor: float) -> float:
    """The misfit with less noise, what runs differ in as it was."""
    from scipy.linalg import solve_triangular

    noise, found = point.noise, float(np.sum((point.space.prior * point.x) ** 2))
    groups = noise.model.groups
    misses = np.split(point.residual, np.cumsum([group.part.size for group in groups])[:-1])
    for group, root, rows, residual in zip(
        groups, noise.roots, noise.run_to_run, misses, strict=True
    ):
        less = variance_factor * (root @ root.T) + (1.0 - variance_factor) / group.count * (
            rows.T @ rows
        )
        white = solve_triangular(np.linalg.cholesky(less), root @ residual, lower=True)
        found += float(white @ white)
    return found
