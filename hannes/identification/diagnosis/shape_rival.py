"""Whether a law stands against a generic disturbance that comes nearly as near.

What is free in shape follows any law to some extent. Where the law is right it fits better, also
after the numbers of both are paid for, and beside it nothing is left for a free shape. Where it is
wrong the shape fits better, or has something left to do beside it. An effect that is nested in a
generic disturbance, as gravity is in a torque over the angle, never fits much better before the
numbers are paid for. There the shape must fit better than chance lets its further numbers.
"""

from collections.abc import Sequence

from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.score_test import Guess, screened
from hannes.identification.diagnosis.trials import SearchResult, Trial
from hannes.identification.diagnosis.tuning import SEARCH


def stands_against(found: SearchResult, trial: Trial, generic: Trial) -> bool:
    """Whether a trial fits better than a generic one, numbers paid, and leaves it nothing."""
    better = (generic.point.chi2 - trial.point.chi2) / found.variance_factor
    priced = trial.delta_chi2 - generic.delta_chi2
    surely = min(better, priced) > SEARCH.rival
    if not surely and not _nested(trial, generic.numbers, better):
        return False
    most = _little(trial) if surely else SEARCH.rival
    return left_beside(found, _shapes(trial.point)) <= most


def raises_no_doubt(trial: Trial, shape: Guess) -> bool:
    """Whether a law stands against a generic disturbance, by what that would do beside it.

    Both together fit no worse than the disturbance alone. The estimate is linear, and may be one
    by a secant of another size, which counts half: so twice that is asked, in noise as assumed.
    """
    beside = 2.0 * shape.delta_chi2
    price = SEARCH.generic_price * (len(shape.places) - 1)
    return beside - price <= SEARCH.rival and _nested(trial, len(shape.places), -beside)


def _nested(trial: Trial, numbers: int, better: float) -> bool:
    """Whether one effect fits as well as a generic disturbance but for chance, which may show that.

    By the likelihood ratio as of nested models (Wilks 1938), which these need not be: the test is
    how much better chance lets further numbers fit. A small effect must fit better: what it does
    not follow, the disturbance would not show. numbers: of the disturbance, which has more
    """
    from scipy.stats import chi2

    law = trial.numbers
    if numbers <= law or len(trial.effects) > 1:
        return False
    large = trial.delta_chi2 > SEARCH.nested_limit * SEARCH.name_limit
    chance = float(chi2.sf(max(0.0, -better), numbers - law))
    return chance > SEARCH.nested_chance and (large or better > 0.0)


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


def _shapes(point: Linearisation) -> list[Guess]:
    """All generic disturbances beside a fit."""
    names = [name for name in GENERIC_NAMES if name in point.space.effects]
    with point.model.work.in_any_case():
        return screened(point, names)


def _little(trial: Trial) -> float:
    """As much as a second effect needs."""
    return max(SEARCH.name_limit, SEARCH.second_share * trial.delta_chi2)
