"""The variance factor: the noise that is really there over the noise that is assumed.

Some machines are noisier in simulation than on the bench. Then the best model leaves less than one
per bin, and noise counts less accordingly. Run-to-run variability keeps its assumed size: few runs
inform about it. Were it reduced too, twelve runs that happened to start late would be a delay.
"""

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.tuning import NOISE


def estimated_variance_factor(baseline: Linearisation, least: float) -> float:
    """Variance of noise per bin, of the least chi-squared of any model; 1 as assumed.

    Bounded below by the tuning constant, and by 1 where noise is known from repeats alone.
    """
    return max(
        NOISE.least_variance_factor if baseline.noise.simulated_noise else 1.0,
        least / baseline.residual.size,
    )


def chi2_reduction(baseline: Linearisation, point: Linearisation, variance_factor: float) -> float:
    """Chi-squared of the baseline less that of a point, with noise of this variance factor."""
    if variance_factor >= 1.0:
        return (baseline.chi2 - point.chi2) / variance_factor
    return _weighed(baseline, variance_factor) - _weighed(point, variance_factor)


def _weighed(point: Linearisation, variance_factor: float) -> float:
    """Chi-squared with less noise and unchanged run-to-run variability."""
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
