"""From the search to a verdict: an effect, a class, a remainder, or nothing that can be named."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES
from hannes.identification.diagnosis.heldout import heldout_reduction
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.reservations import (
    beyond_noise,
    doubt_about,
    explained_share,
    significant_trend,
    small_second_effect,
    something_more,
    trend_text,
)
from hannes.identification.diagnosis.residual_tests import channel_excess
from hannes.identification.diagnosis.trials import SearchResult, Trial, near
from hannes.identification.diagnosis.tuning import SEARCH, VERDICT


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
    if doubt := doubt_about(found, trial):
        return Decision("unknown", (), f"{reason}, but {doubt}", found.baseline)
    if left := something_more(found, trial):
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
    if trend := significant_trend(found, found.baseline):
        return Decision("unknown", (), f"{trend_text(found, trend)}, and {least}", found.baseline)
    if more := beyond_noise(found.baseline, found.bins):
        return Decision(
            "unknown", (), f"refitted, the baseline leaves {more}, and {least}", found.baseline
        )
    if residual := channel_excess(found.baseline):
        where, p_value = residual.where, residual.p_value
        more = f"more in {where} than the machine's own values can (p = {p_value:.1g})"
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


def _clean(found: SearchResult, trial: Trial, reason: str) -> Decision:
    """The decision where nothing more is indicated beside a trial."""
    if len(trial.effects) > 1:
        return _pair(found, trial, reason)
    rivals = near(trial, found.trials)
    if not rivals:
        more = small_second_effect(found, trial)
        kind = "named_with_remainder" if more else "named"
        return Decision(kind, trial.effects, reason + more, trial.point)
    names = (*trial.effects, *(each.effects[0] for each in rivals))
    return Decision("one_of", names, f"{reason}; {_nearest(rivals)}", trial.point)


def _beside(found: SearchResult, trial: Trial, decision: Decision) -> Decision:
    """The decision with a remainder where a small trend is there too.

    Unknown, if the trend alone explains more than the effect.
    """
    trend = significant_trend(found, trial.point, VERDICT.trend_beside_name)
    if trend is None or decision.kind != "named":
        return decision
    instead = significant_trend(found, found.baseline, VERDICT.trend_beside_name)
    reason = f"{decision.reason}; {trend_text(found, trend)}"
    if instead and instead.delta_chi2 > trial.delta_chi2 * found.variance_factor:
        return Decision("unknown", (), reason, found.baseline)
    return replace(decision, kind="named_with_remainder", reason=reason)


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
    explained, first = explained_share(found, trial), found.trials[0]
    if len(trial.effects) > 1:
        explained *= first.delta_chi2 / trial.delta_chi2
    if explained < VERDICT.explained_share or near(first, found.trials):
        return Decision("unknown", (), reason, found.baseline)
    return Decision("named_with_remainder", first.effects, reason, first.point)


def _names(trial: Trial) -> str:
    return " with ".join(name.rpartition(":")[2].replace("_", " ") for name in trial.effects)
