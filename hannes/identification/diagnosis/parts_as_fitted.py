"""The machine simulated with its like parts as far off for themselves as a fit has them.

What parts change is added linearly, from a machine that has none of them off. Where recordings
inform much, what that neglects looks like an effect: of sound hands, mounting or a weak spring.
So they are put into the machine where a fit has found them, and only what they are beyond that is
added.
"""

from dataclasses import replace

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.fitted_deviations import deviations
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation, differenced, with_noise
from hannes.identification.diagnosis.noise_covariance import NoiseCovariance
from hannes.identification.diagnosis.part_deviations import of_parts, part_deviations
from hannes.identification.diagnosis.tuning import FIT


def leaves_noise(point: Linearisation) -> bool:
    """Whether a fit leaves little: what its parts are off for themselves is then no missing law."""
    return point.chi2 < FIT.near_parts * point.residual.size


def with_parts_as_fitted(point: Linearisation, variance_factor: float = 1.0) -> Linearisation:
    """The fit about the machine with its parts where it has them; itself where that fails.

    Nor is it changed where parts would be farther off than like parts are: something else is there.
    """
    for _ in range(FIT.part_rounds):
        there = _once(point, variance_factor)
        if there is None:
            break
        before, point = point, there
        if abs(before.chi2 - there.chi2) < FIT.same_parts:
            break
    return point


def about(point: Linearisation, noise: NoiseCovariance) -> Linearisation | None:
    """The same values of another machine, with its noise; None where it cannot be simulated."""
    vectors, derivatives = differenced(noise.model, point.x, point.active, _has_effects(point))
    if not all(np.isfinite(each).all() for each in vectors):
        return None
    return with_noise(point, noise, vectors, derivatives)


def _once(point: Linearisation, variance_factor: float) -> Linearisation | None:
    off = of_parts(deviations(point, variance_factor))
    if not off or not hasattr(point.model.small, "with_parts"):
        return None
    if max(map(abs, off.values())) > FIT.farthest_part:
        return None
    moved = point.model.with_parts_at(off)
    machine = moved.as_machine() if _has_effects(point) else moved
    try:
        parts = part_deviations(machine, point.x)
    except ComputationFailed:
        return None
    there = about(point, replace(point.noise, model=moved, parts=parts))
    return there and settled(fitted(there, FIT.steps_per_round))


def _has_effects(point: Linearisation) -> bool:
    return point.active.size > point.space.uncertain.size
