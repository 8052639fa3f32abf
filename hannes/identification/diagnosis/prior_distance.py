"""How far a fit takes the machine from its given values, against how far they were told to be off.

A machine that is less well known than it is told to be bends to its recordings only where that is
dear: an effect that it does not have then comes cheaper.
"""

from dataclasses import dataclass

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.tuning import FIT


@dataclass(frozen=True)
class PriorDistance:
    """times: how far values are off, over how far that is told; chance: of so much or more.

    excess: of their squares over what is expected
    """

    ratio: float
    p_value: float
    excess: float


def prior_distance(point: Linearisation) -> PriorDistance:
    """Of all that the recordings tell of the machine's values.

    A value of which they tell the share h is off by a square of h, expected: so many numbers are
    told as these shares add up to, about a chi square.
    """
    from scipy.stats import chi2

    known = point.active < point.space.uncertain.size
    inverse = np.linalg.inv(point.hessian + FIT.jitter * np.eye(point.active.size))
    degrees = max(float(known.sum() - np.trace(inverse[np.ix_(known, known)])), FIT.jitter)
    off = float(np.sum(point.x[point.active[known]] ** 2))
    return PriorDistance((off / degrees) ** 0.5, float(chi2.sf(off, degrees)), off - degrees)
