"""The machine simulated with its like parts as far off for themselves as a fit has them.

What parts change is added linearly, from a machine that has none of them off. Where recordings
inform much, what that neglects looks like an effect: of sound hands, mounting or a weak spring.
So they are put into the machine where a fit has found them, and only what they are beyond that is
added.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.fitted_deviations import deviations
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation, differenced, with_noise
from hannes.identification.diagnosis.noise_covariance import NoiseCovariance
from hannes.identification.diagnosis.part_deviations import of_parts, part_deviations
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.tuning import FIT
from hannes.plants.protocol import PlantOfParts

ANEW = 1  # round in which all derivatives are made anew


def leaves_noise(point: Linearisation, variance_factor: float = 1.0) -> bool:
    """Whether a fit leaves little: what its parts are off for themselves is then no missing law."""
    return point.chi2 < FIT.near_parts * variance_factor * point.residual.size


def with_parts_as_fitted(
    point: Linearisation, variance_factor: float = 1.0
) -> Linearisation | None:
    """The fit about the machine with its parts where it has them; None where that fails.

    None, too, where a part would be more than 4 standard deviations off: something else is there.
    Where little is neglected by what is linear, no part is moved: recordings that inform little
    would only lead parts astray. Derivatives by parts take most of the work. They are made anew
    once, near where the parts stay.
    """
    known = bool(point.model.parts_at)
    for number in range(FIT.part_rounds):
        off = of_parts(deviations(point, variance_factor))
        if _stay(point.model.parts_at, off):
            break
        there = _moved(point, off, number == ANEW and not known)
        if there is None:
            return None
        if not (known or number) and _neglected(point, there) < FIT.little_neglected:
            break
        there = fitted(there, FIT.steps_per_round)
        less, point = point.chi2 - there.chi2, there
        if (known or number > ANEW) and abs(less) < FIT.same_parts:
            break
    return settled(point)


def about(point: Linearisation, noise: NoiseCovariance) -> Linearisation | None:
    """The same values of another machine, with its noise; None where it cannot be simulated."""
    vectors, derivatives = differenced(noise.model, point.x, point.active, _has_effects(point))
    if not all(np.isfinite(each).all() for each in vectors):
        return None
    return with_noise(point, noise, vectors, derivatives)


def _moved(point: Linearisation, off: Mapping[str, float], anew: bool) -> Linearisation | None:
    """The same values with parts off so far, by derivatives made anew or those that are known."""
    known = point.noise.parts
    if known is None or not off or not isinstance(point.model.small, PlantOfParts):
        return None
    if max(map(abs, off.values())) > FIT.farthest_part:
        return None
    moved = point.model.with_parts_at(off)
    if anew:
        return differenced_about(point, moved)
    noise = replace(point.noise, model=moved, parts=replace(known, at=off))
    return with_noise(point, noise).moved(point.x, np.zeros(0, int))


def _neglected(point: Linearisation, there: Linearisation) -> float:
    """Chi-squared of what the rows of parts do not say of how parts change the machine."""
    change = point.residual - there.residual
    return float(change @ change)


def _stay(at: Mapping[str, float], off: Mapping[str, float]) -> bool:
    """Whether parts are where the machine has them."""
    return bool(at) and max(abs(off[n] - at.get(n, 0.0)) for n in off) < FIT.parts_stay


def differenced_about(point: Linearisation, moved: Model) -> Linearisation | None:
    """The same values of the machine with its parts moved, all derivatives made there.

    None where it cannot be simulated.
    """
    machine = moved.as_machine() if _has_effects(point) else moved
    try:
        parts = part_deviations(machine, point.x)
    except ComputationFailed:
        return None
    return about(point, replace(point.noise, model=moved, parts=parts))


def _has_effects(point: Linearisation) -> bool:
    return point.active.size > point.space.uncertain.size
