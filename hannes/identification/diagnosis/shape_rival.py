"""Whether a law stands against a generic disturbance that comes nearly as near.

What is free in shape follows any law to some extent. Where the law is right it fits better, also
after the numbers of both are paid for, and beside it nothing is left for a free shape. Where it is
wrong the shape fits better, or has something left to do beside it. An effect that is nested in a
generic disturbance, as gravity is in a torque over the angle, never fits better before the numbers
are paid for.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.score_test import (
    Guess,
    amplitude_names,
    projected,
    screened,
)
from hannes.identification.diagnosis.trials import SearchResult, Trial
from hannes.identification.diagnosis.tuning import FIT, SEARCH


def stands_against(found: SearchResult, trial: Trial, generic: Trial) -> bool:
    """Whether a trial fits better than a generic one, numbers paid, and leaves it nothing."""
    better = (generic.point.chi2 - trial.point.chi2) / found.variance_factor
    priced = trial.delta_chi2 - generic.delta_chi2
    if priced <= 0.0:
        return False
    shapes = _shapes(trial.point)
    if left_beside(found, shapes) > _little(trial):
        return False
    return min(better, priced) > SEARCH.rival or _nested(trial, shapes, generic)


def _nested(trial: Trial, shapes: Sequence[Guess], generic: Trial) -> bool:
    """Whether one effect is nearly nested in a generic disturbance of more numbers, and large.

    What a large one does not follow, the disturbance would show.
    """
    known = {each.effect: each for each in shapes}
    shape = known.get(generic.effects[0])
    if shape is None or len(trial.effects) > 1:
        return False
    fewer = trial.point.space.of(*trial.effects).size < len(shape.places)
    large = trial.delta_chi2 > SEARCH.nested_limit * SEARCH.name_limit
    return fewer and large and followed(trial, shape) > SEARCH.nested_share


def left_beside(found: SearchResult, shapes: Sequence[Guess]) -> float:
    """What a generic disturbance would lower the misfit by beside a trial, less its price.

    By a linear estimate, all else following.
    """
    return max(
        (
            each.delta_chi2 / found.variance_factor - SEARCH.generic_price * (len(each.places) - 1)
            for each in shapes
        ),
        default=0.0,
    )


def followed(trial: Trial, shape: Guess) -> float:
    """Share of what a trial's effect does, squared, that a generic disturbance can do.

    By the linearisation at the trial, the machine following; noise has no part in it.
    """
    point, [effect] = trial.point, trial.effects
    sizes = [point.space.place(name) for name in amplitude_names(point.space.effects[effect])]
    acting = np.isin(point.active, sizes)
    kept = ~np.isin(point.active, point.space.of(effect))
    machine = replace(point, active=point.active[kept], jacobian=point.jacobian[kept])
    done = point.x[point.active[acting]] @ point.jacobian[acting]
    _, whole = projected(machine, np.vstack([done, shape.signature]))
    own, between, other = whole[0, 0], whole[0, 1:], whole[1:, 1:]
    weights = other + FIT.effect_prior_weight * np.eye(len(other))
    return float(between @ np.linalg.solve(weights, between) / own) if own > 0.0 else 0.0


def _shapes(point: Linearisation) -> list[Guess]:
    """All generic disturbances beside a fit."""
    names = [name for name in GENERIC_NAMES if name in point.space.effects]
    with point.model.work.in_any_case():
        return screened(point, names)


def _little(trial: Trial) -> float:
    """As much as a second effect needs."""
    return max(SEARCH.name_limit, SEARCH.second_share * trial.delta_chi2)
