"""From the search to a verdict: an effect, a class, a remainder, or nothing that can be named."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES
from hannes.identification.diagnosis.heldout import heldout_reduction
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.reservations import (
    beyond_noise,
    doubt_about,
    explained_share,
    significant_trend,
    small_further_effect,
    something_more,
    trend_text,
)
from hannes.identification.diagnosis.residual_tests import channel_excess
from hannes.identification.diagnosis.trials import (
    Joint,
    SearchResult,
    Trial,
    joint_rivals,
    near,
)
from hannes.identification.diagnosis.tuning import SEARCH, VERDICT
from hannes.identification.effect_words import effect_words
from hannes.plants.part_fault import like_faults


@dataclass(frozen=True)
class Decision:
    """The verdict's kind, the effects named, the reason, and the fit that the result stands for.

    held_out: by how much the misfit of runs in role select falls, fitted without them; 0 where
              what was fitted is not among what is named (of a class the first one was)
    """

    kind: str
    effects: tuple[str, ...]
    reason: str
    point: Linearisation
    held_out: float = 0.0


def decide(found: SearchResult, fitted_runs: list[int], heldout_runs: list[int]) -> Decision:
    """The verdict. Both arguments are bit masks of the runs of each group.

    fitted_runs: the training split; heldout_runs: the validation split
    """
    trial = found.best
    if trial is None or trial.delta_chi2 < SEARCH.name_limit:
        return _nothing(found, trial)
    delta_chi2 = (
        heldout_reduction(found.baseline, trial.point, fitted_runs, heldout_runs)
        / found.variance_factor
    )
    reason = (
        f"{_names(trial)} lowers the misfit by {trial.delta_chi2:,.0f} "
        f"(a name needs {SEARCH.name_limit:.0f})"
    )
    if not delta_chi2 >= -allowed(trial.delta_chi2):  # nor where it is not a number
        reason = f"{reason}, but not that of recordings held out ({delta_chi2:,.0f})"
        return Decision("unknown", (), reason, found.baseline)
    if any(fitted_runs) and any(heldout_runs):
        reason += f", that of recordings held out by {delta_chi2:,.0f}"
    if doubt := doubt_about(found, trial):
        return Decision("unknown", (), f"{reason}, but {doubt}", found.baseline)
    if left := something_more(found, trial):
        decision = _of_sure_parts(found, _unclean(found, trial, f"{reason}; {left}"))
    else:
        decision = _beside(found, trial, _clean(found, trial, reason))
    same = decision.effects[: len(trial.effects)] == trial.effects and np.isfinite(delta_chi2)
    return replace(decision, held_out=delta_chi2 if same else 0.0)


def allowed(delta_chi2: float) -> float:
    """How much a name with this reduction may add to the chi-squared of held-out runs."""
    share = VERDICT.heldout_share * delta_chi2
    return min(max(VERDICT.heldout_increase, share), VERDICT.heldout_most)


def _nothing(found: SearchResult, best: Trial | None) -> Decision:
    """The decision where no effect reduces chi-squared enough."""
    delta_chi2 = 0.0 if best is None else best.delta_chi2
    least = (
        f"no effect lowers the misfit by the {SEARCH.name_limit:.0f} that a name needs "
        f"(best {delta_chi2:.1f})"
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
    if best is not None and delta_chi2 >= VERDICT.doubt:
        name = _names(best)
        reason = (
            f"{name} lowers the misfit by {delta_chi2:.1f}, where a name needs "
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
    if found.joint and trial is found.joint.trial:
        return _several(found, found.joint, reason)
    rivals = near(trial, found.trials)
    if not rivals:
        more = small_further_effect(found, trial)
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


def _several(found: SearchResult, joint: Joint, reason: str) -> Decision:
    """The decision for several effects; where others do as well, for those that all share."""
    trial, rivals, sure = joint.trial, joint_rivals(joint), _shared(joint)
    if len(sure) == len(trial.effects):
        return Decision("named", trial.effects, reason, trial.point)
    said = [_nearest(rivals)] if rivals else []
    said += [
        f"{GENERIC_NAMES[generic]} may do what {effect_words(name)} does"
        for name, generic in joint.replaceable.items()
    ]
    return _some_of(found, joint, sure, "; ".join([reason, *said]))


def _shared(joint: Joint) -> set[str]:
    """The effects that all sets share which do as well, and for which nothing else could stand."""
    rivals = (each.effects for each in joint_rivals(joint))
    shared = set(joint.trial.effects).intersection(*rivals)
    return shared - set(joint.replaceable) - _of_some_part(joint)


def _of_some_part(joint: Joint) -> set[str]:
    """Faults that were tried of no other part: the bound of work ended the search before."""
    effects, tried = joint.trial.point.space.effects, joint.others
    return {
        name
        for name in joint.trial.effects
        if (others := set(like_faults(effects, name)))
        and not any(others & set(each.effects) for each in tried)
    }


def _some_of(found: SearchResult, joint: Joint, sure: set[str], reason: str) -> Decision:
    """Those of several effects that are sure, with a remainder, where they explain enough."""
    some = [*joint.without.values(), *found.trials]
    alone = max(
        (each for each in some if set(each.effects) <= sure),
        key=lambda each: each.delta_chi2,
        default=None,
    )
    least = max(SEARCH.name_limit, VERDICT.common_share * joint.trial.delta_chi2)
    if alone is None or alone.delta_chi2 < least:
        return Decision("unknown", (), reason, found.baseline)
    return Decision("named_with_remainder", alone.effects, reason, alone.point)


def _nearest(rivals: Sequence[Trial]) -> str:
    return f"{_names(rivals[0])} lowers it nearly as much, by {rivals[0].delta_chi2:,.0f}"


def _unclean(found: SearchResult, trial: Trial, reason: str) -> Decision:
    """The decision where something more than a trial is indicated."""
    explained = explained_share(found, trial)
    if explained < VERDICT.explained_share:
        return _best_alone(found, trial, reason)
    if found.joint:
        return _surely_missed(found, found.joint, explained, reason)
    if near(trial, found.trials):
        if found.cut_short and not something_more(replace(found, cut_short=False), trial):
            return _clean(found, trial, reason)
        return Decision("unknown", (), reason, found.baseline)
    return Decision("named_with_remainder", trial.effects, reason, trial.point)


def _of_sure_parts(found: SearchResult, decision: Decision) -> Decision:
    """The decision without faults of one of like parts, where it leaves much beyond noise.

    What else is missing decides there which part fits best.
    """
    if decision.point.chi2 <= VERDICT.clean * found.bins or not decision.effects:
        return decision
    effects = decision.point.space.effects
    sure = {name for name in decision.effects if not like_faults(effects, name)}
    if len(sure) == len(decision.effects):
        return decision
    reason = f"{decision.reason}; what is left may decide which part has a fault"
    if not (sure and found.joint):
        return Decision("unknown", (), reason, found.baseline)
    return _some_of(found, found.joint, sure, reason)


def _best_alone(found: SearchResult, trial: Trial, reason: str) -> Decision:
    """Of several effects that do not stand together the best one, where it does by itself."""
    alone = found.trials[0] if found.trials else None
    stands = (
        alone is not None
        and found.joint is not None
        and set(alone.effects) <= set(trial.effects)
        and explained_share(found, alone) >= VERDICT.explained_share
        and not near(alone, found.trials)
        and not doubt_about(found, alone)
    )
    if alone is None or not stands:
        return Decision("unknown", (), reason, found.baseline)
    return Decision("named_with_remainder", alone.effects, reason, alone.point)


def _surely_missed(found: SearchResult, joint: Joint, explained: float, reason: str) -> Decision:
    """Of several effects those that each explain much more than what is left."""
    trial, rest = joint.trial, (1.0 / explained - 1.0) * joint.trial.delta_chi2
    least = rest * VERDICT.explained_share / (1.0 - VERDICT.explained_share)
    sure = {name for name in _shared(joint) if joint.losses[name] >= least}
    if len(sure) == len(trial.effects):
        return Decision("named_with_remainder", trial.effects, reason, trial.point)
    return _some_of(found, joint, sure, reason)


def _names(trial: Trial) -> str:
    return " with ".join(map(effect_words, trial.effects))
