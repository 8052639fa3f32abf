"""Mahalanobis distance of the fitted machine from its prior.

A machine that is less well known than assumed follows its recordings only at a price. An effect
that it does not have is then cheaper.
"""

from dataclasses import dataclass

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.tuning import FIT


@dataclass(frozen=True)
class PriorDistance:
    """Distance of a fitted machine from its nominal values.

    ratio: root mean square over the expected one;  p_value: of as much or more by chance
    excess: of the squared distance over its expectation
    """

    ratio: float
    p_value: float
    excess: float


def prior_distance(point: Linearisation) -> PriorDistance:
    """Distance in all parameters that the recordings inform about.

    A parameter of which they know the share h is off by a square of h, in expectation. These
    shares add up to the degrees of freedom of about a chi-squared.
    """
    from scipy.stats import chi2

    known = point.active < point.space.uncertain.size
    inverse = np.linalg.inv(point.hessian + FIT.jitter * np.eye(point.active.size))
    degrees = max(float(known.sum() - np.trace(inverse[np.ix_(known, known)])), FIT.jitter)
    off = float(np.sum(point.x[point.active[known]] ** 2))
    return PriorDistance((off / degrees) ** 0.5, float(chi2.sf(off, degrees)), off - degrees)
