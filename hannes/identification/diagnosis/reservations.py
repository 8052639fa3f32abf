"""What speaks against a name, or indicates something beside it."""

from collections.abc import Sequence

import numpy as np

from hannes.core.effect import Effect
from hannes.core.parameter import Parameter
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.prior_distance import PriorDistance, prior_distance
from hannes.identification.diagnosis.residual_tests import (
    StructuredResidual,
    autocorrelated,
    channel_excess,
)
from hannes.identification.diagnosis.score_test import Guess
from hannes.identification.diagnosis.shape_rival import stands_against
from hannes.identification.diagnosis.trend import Trend, strongest_trend
from hannes.identification.diagnosis.trials import SearchResult, Trial, near
from hannes.identification.diagnosis.tuning import FIT, SEARCH, VERDICT
from hannes.identification.effect_words import effect_words
from hannes.plants.part_fault import moved_by


def beyond_noise(point: Linearisation, bins: int) -> str:
    """What a fit leaves beyond noise, in words; an empty string where there is nothing."""
    if point.chi2 > VERDICT.clean * bins:
        return f"{point.chi2 / bins:.2f} per bin (1 expected)"
    if residual := autocorrelated(point):
        return f"more in {residual.where} than chance (p = {residual.p_value:.1g})"
    return ""


def doubt_about(found: SearchResult, trial: Trial) -> str:
    """Why effects that explain much are not what is there, or an empty string."""
    if name := _stretched(found, trial):
        return f"only with {name} at an end of its range and beyond: something like it is there"
    generic = found.generic
    if generic and generic.delta_chi2 > SEARCH.faint and _as_near(trial, generic):
        if not stands_against(found, trial, generic):
            generic_name = GENERIC_NAMES[generic.effects[0]]
            lowered = f"{generic.delta_chi2:.0f}"
            return f"{generic_name} lowers it by {lowered} too: something else may be there"
    return ""


def _as_near(trial: Trial, generic: Trial) -> bool:
    """Whether a generic disturbance comes as near; several laws are held to no share of theirs."""
    if len(trial.effects) > 1:
        return generic.delta_chi2 > trial.delta_chi2 - SEARCH.rival
    return bool(near(trial, [generic]))


def _stretched(found: SearchResult, trial: Trial) -> str:
    """A parameter that would leave its physical range, in words, or an empty string."""
    least = VERDICT.beyond_range * found.variance_factor
    for place, words in ends_reached(trial.point, trial.effects).items():
        if _beyond(trial.point, place) > least:
            return words
    return ""


def ends_reached(point: Linearisation, effects: Sequence[str]) -> dict[int, str]:
    """Parameters of effects at an end of their ranges, by index, in words."""
    space, found = point.space, {}
    for effect in (space.effects[name] for name in effects):
        for each in effect.fitted:
            place = space.place(effect.full_name(each.name))
            value = float(space.parameters[place].value(point.x[place]))
            if _at_end(each, value) and not _gone(point, effect, each.name):
                found[place] = f"{effect.name}'s {each.name}".replace("_", " ")
    return found


def _gone(point: Linearisation, effect: Effect, parameter: str) -> bool:
    """Whether a fault has taken all that the machine has of something: no more can be lost."""
    moved = moved_by(effect, parameter)
    declared = point.model.small.parameters.declared
    values = point.space.values(point.x) if moved else {}
    return bool(moved) and all(
        min(abs(values[name] - end) for end in declared[name].bounds) <= 1e-9 for name in moved
    )


def _at_end(parameter: Parameter, value: float) -> bool:
    """Whether a range ends there: `off` is no end, and counts and angles have none."""
    low, high = parameter.bounds
    ends = [end for end in (low, high) if end != parameter.off]
    endless = parameter.turns is not None or parameter.tried
    return not endless and min(abs(value - end) for end in ends) <= 1e-9 * (high - low)


def _beyond(point: Linearisation, place: int) -> float:
    """Reduction of chi-squared by a step along one parameter, all else following.

    At an end of its range that is a step out of it: a fit that could go inward has gone.
    """
    number = int(np.searchsorted(point.active, place))
    inverse = np.linalg.inv(point.hessian + FIT.jitter * np.eye(point.active.size))
    return float(point.gradient[number] ** 2 * inverse[number, number])


def something_more(found: SearchResult, trial: Trial) -> str:
    """What indicates something more than the effects of a trial, or an empty string."""
    if trend := significant_trend(found, trial.point):
        return trend_text(found, trend)
    if more := beyond_noise(trial.point, found.bins):
        return f"what is left is {more}"
    if residual := _underexplained(found, trial):
        more = f"{residual.excess / found.variance_factor:.0f} stand out in {residual.where} alone"
        return f"{more}, so something else is there"
    rest, needed = found.remaining, max(SEARCH.name_limit, SEARCH.second_share * trial.delta_chi2)
    if rest is not None and rest.delta_chi2 / found.variance_factor > needed:
        return f"{_further(found, rest)}, so something else is there"
    if found.cut_short:
        return "the search for further effects was ended at its bound, so more may be there"
    if far := far_from_prior(trial):
        ratio = f"{far.ratio:.1f} times as far as scatter allows"
        return f"it takes a machine whose values are off {ratio}: so they are, or hide something"
    return ""


def far_from_prior(trial: Trial) -> PriorDistance | None:
    """How far the machine fitted with these effects is off its prior, where that is improbable."""
    found = prior_distance(trial.point)
    return found if found.p_value < VERDICT.prior_p_value else None


def _underexplained(found: SearchResult, trial: Trial) -> StructuredResidual | None:
    """Excess of one channel of the baseline, where the trial explains far less than that in all.

    What appears in one channel alone is about as large by both, and which is larger is chance.
    """
    residual = channel_excess(found.baseline)
    return (
        residual
        if residual is not None
        and VERDICT.explained_share * residual.excess > _lowered(found, trial)
        else None
    )


def _lowered(found: SearchResult, trial: Trial) -> float:
    return found.baseline.chi2 - trial.point.chi2


def significant_trend(
    found: SearchResult, point: Linearisation, least: float = VERDICT.trend_limit
) -> Trend | None:
    """A trend across runs that reduces chi-squared by at least `least`."""
    trend = strongest_trend(point, found.guesses)
    return trend if trend is not None and trend.delta_chi2 > least * found.variance_factor else None


def trend_text(found: SearchResult, trend: Trend) -> str:
    """A trend across runs in words."""
    name = effect_words(trend.effect)
    further = trend.delta_chi2 / found.variance_factor
    return (
        f"by a linear estimate, not fitted, {further:.0f} would go with {name} that grows from run "
        "to run"
    )


def small_further_effect(found: SearchResult, trial: Trial) -> str:
    """A further effect too small to be named, in words, or an empty string."""
    rest = found.remaining
    if rest is None or rest.delta_chi2 / found.variance_factor < max(
        VERDICT.remainder, 0.5 * SEARCH.second_share * trial.delta_chi2
    ):
        return ""
    return f"; {_further(found, rest)}, too little to name it"


def _further(found: SearchResult, rest: Guess) -> str:
    """What one more effect would explain, and whether it was fitted."""
    name, further = effect_words(rest.effect), rest.delta_chi2 / found.variance_factor
    if rest.refitted:
        return f"{name} beside it lowers the misfit by {further:.0f} more"
    return f"by a linear estimate, not fitted, {further:.0f} more would go with {name}"


def explained_share(found: SearchResult, trial: Trial) -> float:
    """Share that a trial explains of all that indicates a missing effect, nothing of it scaled.

    Zero where a trend across runs would explain more.
    """
    delta_chi2, residual = _lowered(found, trial), autocorrelated(trial.point)
    trend, instead = (significant_trend(found, p) for p in (trial.point, found.baseline))
    if trend and instead and instead.delta_chi2 > delta_chi2:
        return 0.0
    beyond = max(found.baseline.chi2 - found.bins, 1.0)
    far = far_from_prior(trial)
    rests = (
        residual.excess if residual else 0.0,
        trend.delta_chi2 if trend else 0.0,
        far.excess if far else 0.0,
    )
    shares = [delta_chi2 / beyond, *(delta_chi2 / (delta_chi2 + rest) for rest in rests)]
    if out := _underexplained(found, trial):
        shares.append(delta_chi2 / out.excess)
    return min(shares)
