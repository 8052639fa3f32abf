"""Whether a law stands against a generic disturbance that comes nearly as near.

What is free in shape follows any law to some extent. Where the law is right it fits better, also
after the numbers of both are paid for, and beside it nothing is left for a free shape. Where it is
wrong the shape fits better, or has something left to do beside it.
"""

from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES
from hannes.identification.diagnosis.score_test import screened
from hannes.identification.diagnosis.trials import SearchResult, Trial
from hannes.identification.diagnosis.tuning import SEARCH


def stands_against(found: SearchResult, trial: Trial, generic: Trial) -> bool:
    """Whether a trial fits better than a generic one, numbers paid, and leaves it nothing."""
    better = (generic.point.chi2 - trial.point.chi2) / found.variance_factor
    priced = trial.delta_chi2 - generic.delta_chi2
    return min(better, priced) > SEARCH.rival and left_beside(found, trial) <= _little(trial)


def left_beside(found: SearchResult, trial: Trial) -> float:
    """What a generic disturbance would lower the misfit by beside a trial, less its price.

    By a linear estimate, all else following.
    """
    names = [name for name in GENERIC_NAMES if name in trial.point.space.effects]
    with trial.point.model.work.in_any_case():
        guesses = screened(trial.point, names)
    return max(
        (
            each.delta_chi2 / found.variance_factor - SEARCH.generic_price * (len(each.places) - 1)
            for each in guesses
        ),
        default=0.0,
    )


def _little(trial: Trial) -> float:
    """As much as a second effect needs."""
    return max(SEARCH.name_limit, SEARCH.second_share * trial.delta_chi2)
