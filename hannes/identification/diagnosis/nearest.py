"""Of an `unknown`: the candidates that come nearest, and why none of them is believed."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from hannes.identification.diagnosis.decision import Decision
from hannes.identification.diagnosis.reservations import doubt_about, something_more
from hannes.identification.diagnosis.trials import SearchResult, Trial
from hannes.identification.diagnosis.tuning import SEARCH, VERDICT


def nearest(
    found: SearchResult, decision: Decision, names: Mapping[str, str]
) -> list[dict[str, Any]]:
    """`effects`, the share that each `explains` of what is missing, and `why_not`; best first.

    names: effect -> name by which it can be found again. Empty for every other verdict, and where
    no candidate reduces chi-squared by the limit at which an effect is named.
    """
    if decision.kind != "unknown":
        return []
    trials = [*([found.joint.trial] if found.joint else []), *found.trials]
    enough = [each for each in trials if each.delta_chi2 >= SEARCH.name_limit]
    enough.sort(key=lambda each: -each.delta_chi2)
    return [
        {
            "effects": [names[name] for name in each.effects],
            "explains": _share(found, each),
            "why_not": _why_not(found, each, enough[0]),
        }
        for each in enough[: VERDICT.nearest]
    ]


def _share(found: SearchResult, trial: Trial) -> float:
    """Of what the baseline leaves above noise, 0 to 1."""
    above = found.baseline.chi2 - found.bins
    lowered = found.baseline.chi2 - trial.point.chi2
    return float(min(1.0, max(0.0, lowered / max(above, lowered, 1.0))))


def _why_not(found: SearchResult, trial: Trial, best: Trial) -> str:
    if trial is not best and trial.delta_chi2 < VERDICT.explained_share * best.delta_chi2:
        return "it explains much less than the first"
    if found.joint and trial is not found.joint.trial:  # what is left is that beside those others
        found = replace(found, joint=None, remaining=None)
    return (
        doubt_about(found, trial)
        or something_more(found, trial)
        or "the reason of the verdict speaks against it"
    )
