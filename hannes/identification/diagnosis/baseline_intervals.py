"""How far the refitted baseline lies from the nominal machine, with intervals."""

from typing import Any

import numpy as np

from hannes.identification.baseline_table import Refitted, baseline_table
from hannes.identification.diagnosis.linearisation import Linearisation

INTERVALS_FROM = "the Gauss-Newton Hessian with priors at the refitted baseline"


def refitted_baseline(point: Linearisation, variance_factor: float) -> dict[str, Any]:
    """Key `baseline` of verdict.json, from the baseline fit.

    variance_factor: by which chi-squared is divided: noise above the assumed widens intervals, but
    none becomes wider than its prior
    """
    space, declared = point.space, point.model.whole.parameters.declared
    noise = variance_factor
    hessian = point.jacobian @ point.jacobian.T / noise + np.diag(point.prior**2)
    deviations = np.sqrt(np.diag(np.linalg.inv(hessian)))
    found = []
    for place, deviation in zip(point.active.tolist(), deviations.tolist(), strict=True):
        each = space.parameters[place]
        value = float(each.value(point.x[place]))
        found.append(
            Refitted(
                each.name,
                declared[each.name].unit,
                each.centre,
                value,
                deviation * each.scale,
                each.scale,
                (each.low, each.high),
                each.owner,
            )
        )
    return baseline_table(found, INTERVALS_FROM)
