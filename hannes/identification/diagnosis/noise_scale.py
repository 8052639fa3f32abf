"""The variance factor: the noise that is really there over the noise that is assumed.

Some machines are noisier on the bench than in simulation. Then the best model leaves more than one
per bin, and noise counts accordingly. Where it leaves less, noise counts as assumed: it is less on
the average of bins alone, and by that average sound machines would look wrong in some of them.
"""

from hannes.identification.diagnosis.linearisation import Linearisation


def estimated_variance_factor(baseline: Linearisation, least: float) -> float:
    """Variance of noise per bin, of the least chi-squared of any model; 1 as assumed, at least."""
    return max(1.0, least / baseline.residual.size)
