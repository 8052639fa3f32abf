"""The variance factor: the noise that is really there over the noise that is assumed.

Some machines are noisier in simulation than on the bench. Then the best model leaves less than one
per bin, and noise counts less accordingly. Run-to-run variability keeps its assumed size: few runs
inform about it. Were it reduced too, twelve runs that happened to start late would be a delay.
"""

from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation, whitened_residual
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
    """Chi-squared with less noise; what runs and parts differ by is unchanged."""
    noise = point.noise
    less = [
        variance_factor * covariance + (1.0 - variance_factor) / group.count * (rows.T @ rows)
        for group, covariance, rows in zip(
            noise.model.groups, noise.covariances, noise.run_to_run, strict=True
        )
    ]
    left = whitened_residual(replace(noise, covariances=less), point.vectors)
    return float(left @ left + np.sum((point.space.prior * point.x) ** 2))
