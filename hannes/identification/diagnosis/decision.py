"""From the search to a verdict: an effect, a class, a remainder, or nothing that can be named."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.core.parameter import Parameter
from hannes.identification.diagnosis.effect_search import (
    SearchResult,
    Trial,
    near,
)
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES
from hannes.identification.diagnosis.heldout import heldout_reduction
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.prior_distance import PriorDistance, prior_distance
from hannes.identification.diagnosis.residual_tests import (
    StructuredResidual,
    autocorrelated,
    channel_excess,
)
from hannes.identification.diagnosis.trend import Trend, strongest_trend
from hannes.identification.diagnosis.tuning import FIT, SEARCH, VERDICT


@dataclass(frozen=True)
class Decision:
    """The verdict's kind, the effects named, the reason, and the fit that the result stands for."""

    kind: str
    effects: tuple[str, ...]
    reason: str
    point: Linearisation


def decide(found: SearchResult, fitted_runs: list[int], heldout_runs: list[int]) -> Decision:
    """The verdict. Both arguments are bit masks of the runs of each group.

    fitted_runs: the training split; heldout_runs: the validation split
    """
    best = found.trials[0] if found.trials else None
    if best is None or best.delta_chi2 < SEARCH.name_limit:
        return _nothing(found, best)
    trial = found.pair or best
    delta_chi2 = (
        heldout_reduction(found.baseline, trial.point, fitted_runs, heldout_runs)
        / found.variance_factor
    )
    reason = (
        f"{_names(trial)} lowers the misfit by {trial.delta_chi2:.0f} "
        f"(limit {SEARCH.name_limit:.0f})"
    )
    if not delta_chi2 >= -allowed(trial.delta_chi2):  # nor where it is not a number
        reason = f"{reason}, but not that of recordings held out ({delta_chi2:.0f})"
        return Decision("unknown", (), reason, found.baseline)
    if any(fitted_runs) and any(heldout_runs):
        reason += f", that of recordings held out by {delta_chi2:.0f}"
    if doubt := _doubted(found, trial):
        return Decision("unknown", (), f"{reason}, but {doubt}", found.baseline)
    if left := _left(found, trial):
        return _unclean(found, trial, f"{reason}; {left}")
    return _beside(found, trial, _clean(found, trial, reason))


def allowed(delta_chi2: float) -> float:
    """How much a name with this reduction may add to the chi-squared of held-out runs."""
    return min(max(VERDICT.heldout_increase, VERDICT.heldout_share * delta_chi2), SEARCH.name_limit)


def _nothing(found: SearchResult, best: Trial | None) -> Decision:
    """The decision where no effect reduces chi-squared enough."""
    delta_chi2 = 0.0 if best is None else best.delta_chi2
    least = (
        f"no effect lowers the misfit by the {SEARCH.name_limit:.0f} that a name needs "
        f"(best {delta_chi2:.0f})"
    )
    if trend := _trend(found, found.baseline):
        return Decision("unknown", (), f"{_trend_text(found, trend)}, and {least}", found.baseline)
    if more := _more(found.baseline, found.bins):
        return Decision(
            "unknown", (), f"refitted, the baseline leaves {more}, and {least}", found.baseline
        )
    if slow := channel_excess(found.baseline):
        more = f"more in {slow.where} than the machine's own values can (p = {slow.p_value:.1g})"
        return Decision(
            "unknown", (), f"refitted, the baseline leaves {more}, and {least}", found.baseline
        )
    if found.generic and found.generic.delta_chi2 >= VERDICT.generic_limit:
        generic_name = GENERIC_NAMES[found.generic.effects[0]]
        reason = (
            f"{generic_name} would lower the misfit by {found.generic.delta_chi2:.0f}, and {least}"
        )
        return Decision("unknown", (), reason, found.baseline)
    if delta_chi2 >= VERDICT.doubt:
        name = _names(found.trials[0])
        reason = (
            f"{name} lowers the misfit by {delta_chi2:.0f}, where a name needs "
            f"{SEARCH.name_limit:.0f}"
        )
        return Decision("unknown", (), reason, found.baseline)
    if found.nominal.chi2 <= VERDICT.agrees * found.bins:
        return Decision(
            "no_gap", (), f"as given it leaves what is expected, and {least}", found.baseline
        )
    per_bin = found.baseline.chi2 / found.bins
    reason = f"refitted, the baseline leaves {per_bin:.2f} per bin (1 expected), and {least}"
    return Decision("recalibrated", (), reason, found.baseline)


def _more(point: Linearisation, bins: int) -> str:
    """What a fit leaves beyond noise, in words; an empty string where there is nothing."""
    if point.chi2 > VERDICT.clean * bins:
        return f"{point.chi2 / bins:.2f} per bin (1 expected)"
    if slow := autocorrelated(point):
        return f"more in {slow.where} than chance (p = {slow.p_value:.1g})"
    return ""


def _doubted(found: SearchResult, trial: Trial) -> str:
    """Why effects that explain much are not what is there, or an empty string."""
    if name := _stretched(found, trial):
        return f"only with {name} at an end of its range and beyond: something like it is there"
    if found.generic and found.generic.delta_chi2 > SEARCH.faint and near(trial, [found.generic]):
        generic_name = GENERIC_NAMES[found.generic.effects[0]]
        return f"{generic_name} does by {found.generic.delta_chi2:.0f}: something else may be there"
    return ""


def _stretched(found: SearchResult, trial: Trial) -> str:
    """A parameter that would leave its physical range, in words, or an empty string."""
    space = trial.point.space
    for effect in (space.effects[name] for name in trial.effects):
        for each in effect.parameters:
            place = space.place(effect.full_name(each.name))
            value = float(space.parameters[place].value(trial.point.x[place]))
            if (
                _at_end(each, value)
                and _beyond(trial.point, place) > VERDICT.beyond_range * found.variance_factor
            ):
                return f"{effect.name}'s {each.name}".replace("_", " ")
    return ""


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


def _left(found: SearchResult, trial: Trial) -> str:
    """What indicates something more than the effects of a trial, or an empty string."""
    if trend := _trend(found, trial.point):
        return _trend_text(found, trend)
    if more := _more(trial.point, found.bins):
        return f"what is left is {more}"
    if slow := _underexplained(found, trial):
        more = f"{slow.excess / found.variance_factor:.0f} stand out in {slow.where} alone"
        return f"{more}, so something else is there"
    rest, needed = found.remaining, max(SEARCH.name_limit, SEARCH.second_share * trial.delta_chi2)
    if rest is not None and rest.delta_chi2 / found.variance_factor > needed:
        more = rest.effect.replace("_", " ")
        further = rest.delta_chi2 / found.variance_factor
        return f"{further:.0f} more would go with {more}, so something else is there"
    if far := _far_from_prior(trial):
        ratio = f"{far.ratio:.1f} times as far as scatter allows"
        return f"it takes a machine whose values are off {ratio}: so they are, or hide something"
    return ""


def _far_from_prior(trial: Trial) -> PriorDistance | None:
    """How far the machine fitted with these effects is off its prior, where that is improbable."""
    found = prior_distance(trial.point)
    return found if found.p_value < VERDICT.prior_p_value else None


def _underexplained(found: SearchResult, trial: Trial) -> StructuredResidual | None:
    """Excess of one channel of the baseline, where the trial explains far less than that in all.

    What appears in one channel alone is about as large by both, and which is larger is chance.
    """
    slow = channel_excess(found.baseline)
    return (
        slow
        if slow is not None and VERDICT.explained_share * slow.excess > _lowered(found, trial)
        else None
    )


def _lowered(found: SearchResult, trial: Trial) -> float:
    return found.baseline.chi2 - trial.point.chi2


def _trend(
    found: SearchResult, point: Linearisation, least: float = VERDICT.trend_limit
) -> Trend | None:
    """A trend across runs that reduces chi-squared by at least `least`."""
    trend = strongest_trend(point, found.guesses)
    return trend if trend is not None and trend.delta_chi2 > least * found.variance_factor else None


def _trend_text(found: SearchResult, trend: Trend) -> str:
    name = trend.effect.replace("_", " ")
    further = trend.delta_chi2 / found.variance_factor
    return f"{further:.0f} would go with {name} that grows from run to run"


def _clean(found: SearchResult, trial: Trial, reason: str) -> Decision:
    """The decision where nothing more is indicated beside a trial."""
    if len(trial.effects) > 1:
        return _pair(found, trial, reason)
    rivals = near(trial, found.trials)
    if not rivals:
        more = _faintly(found, trial)
        kind = "named_with_remainder" if more else "named"
        return Decision(kind, trial.effects, reason + more, trial.point)
    names = (*trial.effects, *(each.effects[0] for each in rivals))
    return Decision("one_of", names, f"{reason}; {_nearest(rivals)}", trial.point)


def _beside(found: SearchResult, trial: Trial, decision: Decision) -> Decision:
    """The decision with a remainder where a small trend is there too.

    Unknown, if the trend alone explains more than the effect.
    """
    trend = _trend(found, trial.point, VERDICT.trend_beside_name)
    if trend is None or decision.kind != "named":
        return decision
    instead = _trend(found, found.baseline, VERDICT.trend_beside_name)
    reason = f"{decision.reason}; {_trend_text(found, trend)}"
    if instead and instead.delta_chi2 > trial.delta_chi2 * found.variance_factor:
        return Decision("unknown", (), reason, found.baseline)
    return replace(decision, kind="named_with_remainder", reason=reason)


def _faintly(found: SearchResult, trial: Trial) -> str:
    """A second effect too small to be named, in words, or an empty string."""
    rest = found.remaining
    if rest is None or rest.delta_chi2 / found.variance_factor < max(
        VERDICT.remainder, 0.5 * SEARCH.second_share * trial.delta_chi2
    ):
        return ""
    name = rest.effect.replace("_", " ")
    further = rest.delta_chi2 / found.variance_factor
    return f"; {further:.0f} more would go with {name}, too little to name it"


def _pair(found: SearchResult, trial: Trial, reason: str) -> Decision:
    """The decision for two effects; where other pairs do as well, what all of them share."""
    rivals = near(trial, found.other_pairs)
    if not rivals:
        return Decision("named", trial.effects, reason, trial.point)
    reason = f"{reason}; {_nearest(rivals)}"
    common = set(trial.effects).intersection(*(each.effects for each in rivals))
    alone = [each for each in found.trials if set(each.effects) <= common]
    if not alone or alone[0].delta_chi2 < max(
        SEARCH.name_limit, VERDICT.common_share * trial.delta_chi2
    ):
        return Decision("unknown", (), reason, found.baseline)
    return Decision("named_with_remainder", alone[0].effects, reason, alone[0].point)


def _nearest(rivals: Sequence[Trial]) -> str:
    return f"{_names(rivals[0])} comes as near as {rivals[0].delta_chi2:.0f}"


def _unclean(found: SearchResult, trial: Trial, reason: str) -> Decision:
    """The decision where something more than a trial is indicated."""
    explained, first = _explained(found, trial), found.trials[0]
    if len(trial.effects) > 1:
        explained *= first.delta_chi2 / trial.delta_chi2
    if explained < VERDICT.explained_share or near(first, found.trials):
        return Decision("unknown", (), reason, found.baseline)
    return Decision("named_with_remainder", first.effects, reason, first.point)


def _explained(found: SearchResult, trial: Trial) -> float:
    """Share that a trial explains of all that indicates a missing effect.

    Zero where a trend across runs would explain more.
    """
    delta_chi2, slow = trial.delta_chi2 * found.variance_factor, autocorrelated(trial.point)
    trend, instead = (_trend(found, p) for p in (trial.point, found.baseline))
    if trend and instead and instead.delta_chi2 > delta_chi2:
        return 0.0
    beyond = max(found.baseline.chi2 - min(1.0, found.variance_factor) * found.bins, 1.0)
    far = _far_from_prior(trial)
    rests = (
        slow.excess if slow else 0.0,
        trend.delta_chi2 if trend else 0.0,
        far.excess if far else 0.0,
    )
    shares = [delta_chi2 / beyond, *(delta_chi2 / (delta_chi2 + rest) for rest in rests)]
    if out := _underexplained(found, trial):
        shares.append(_lowered(found, trial) / out.excess)
    return min(shares)


def _names(trial: Trial) -> str:
    return " with ".join(name.rpartition(":")[2].replace("_", " ") for name in trial.effects)
