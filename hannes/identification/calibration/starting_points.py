"""Starting points, scattered evenly about the nominal values."""

import numpy as np

from hannes.identification.calibration.scaling import Scales
from hannes.identification.calibration.settings import Plan
from hannes.identification.calibration.tuning import CALIBRATION


def scattered(plan: Plan, scales: Scales, count: int) -> list[np.ndarray]:
    """`count` points x in a box of one spread about the nominal values, bounded (Sobol)."""
    from scipy.stats import qmc

    if count == 0:
        return []
    reach = np.minimum(1.0 / scales.prior, CALIBRATION.start_reach)
    low, high = np.maximum(-reach, scales.low), np.minimum(reach, scales.high)
    sobol = qmc.Sobol(reach.size, seed=np.random.default_rng(plan.seed))
    power = int(np.ceil(np.log2(max(count, 2))))
    return list((low + sobol.random_base2(power) * (high - low))[:count])
