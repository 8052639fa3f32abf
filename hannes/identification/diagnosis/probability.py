"""How probable each explanation is, given these recordings.

Explanations are: nothing is missing; each set of effects that was fitted; something else, that no
catalogue has. Each is weighed by what is expected before any recording and by its likelihood, its
parameters paid for. No law is right to more than a share of what it explains, so likelihoods are
tempered by that. Something else has any shape and explains all above noise, at its own price.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hannes.identification.diagnosis.decision import Decision
from hannes.identification.diagnosis.reservations import explained_share
from hannes.identification.diagnosis.trials import SearchResult, Trial
from hannes.identification.diagnosis.tuning import PROBABILITY

Weights = dict[frozenset[str], float]  # effects -> probability
NOTHING: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Probabilities:
    """effects: of each set of effects alone, of the empty set that nothing is missing.

    something_else: that what is missing, or a part of it, is in no catalogue
    """

    effects: Weights
    something_else: float


def probabilities(found: SearchResult, decision: Decision) -> Probabilities:
    """Of every explanation; they sum to one.

    decision: an unknown says that no set of effects is believed, whatever it explains
    """
    trials = _tried(found)
    best = max([0.0, *(each.delta_chi2 for each in trials.values())])
    temper = 2.0 * max(1.0, PROBABILITY.law_error * best)
    logs = {NOTHING: math.log(PROBABILITY.nothing)}
    known = math.log(1.0 - PROBABILITY.nothing - PROBABILITY.something_else)
    count = max(1, len(found.guesses))
    for effects, trial in trials.items():
        further = (len(effects) - 1) * math.log(PROBABILITY.further / count)
        paid = trial.delta_chi2 - PROBABILITY.first_price
        logs[effects] = known - math.log(count) + further + paid / temper
        if decision.kind == "unknown":
            logs[effects] += math.log(PROBABILITY.refused)
    other = math.log(PROBABILITY.something_else) + _anything(found, best) / temper
    return _normalised(logs, other)


def _tried(found: SearchResult) -> dict[frozenset[str], Trial]:
    """The best fit of every set of effects."""
    every = list(found.trials)
    if found.joint:
        every += [found.joint.trial, *found.joint.others, *found.joint.without.values()]
    tried: dict[frozenset[str], Trial] = {}
    for each in every:
        effects = frozenset(each.effects)
        if effects not in tried or each.delta_chi2 > tried[effects].delta_chi2:
            tried[effects] = each
    return tried


def _anything(found: SearchResult, best: float) -> float:
    """What a law of any shape lowers the misfit by, its price paid."""
    noise = min(1.0, found.variance_factor) * found.bins
    above = max(best, (found.baseline.chi2 - noise) / found.variance_factor)
    share = (1.0 - PROBABILITY.law_share) * above
    generic = found.generic.delta_chi2 if found.generic else 0.0
    return max(share - PROBABILITY.shape_price, generic - PROBABILITY.shape_price)


def _normalised(logs: Mapping[frozenset[str], float], other: float) -> Probabilities:
    most = max([other, *logs.values()])
    total = math.exp(other - most) + sum(math.exp(each - most) for each in logs.values())
    return Probabilities(
        {effects: math.exp(each - most) / total for effects, each in logs.items()},
        math.exp(other - most) / total,
    )


def of_answer(found: SearchResult, decision: Decision, known: Probabilities) -> float:
    """Probability that the verdict is right.

    Of effects with a remainder, that those are there, whatever else is.
    """
    named = frozenset(decision.effects)
    if decision.kind in ("no_gap", "recalibrated"):
        return known.effects[NOTHING]
    if decision.kind == "one_of":
        return sum(known.effects.get(frozenset({name}), 0.0) for name in named)
    if decision.kind == "named":
        return known.effects.get(named, 0.0)
    if decision.kind == "named_with_remainder":
        sets = sum(each for effects, each in known.effects.items() if named <= effects)
        return sets + known.something_else * _mimicked(found, decision)
    return known.something_else


def _mimicked(found: SearchResult, decision: Decision) -> float:
    """Probability that effects are there beside something else, and are not led there by it."""
    named = _tried(found).get(frozenset(decision.effects))
    return explained_share(found, named) ** PROBABILITY.beside_power if named else 0.0


def tabled_probabilities(
    found: SearchResult, decision: Decision, names: Mapping[str, str]
) -> dict[str, Any]:
    """The table of verdict.json: `answer`, `nothing`, `something_else`, and `effects`.

    names: effect -> name by which it can be found again. Empty where the search was ended: what it
    has not seen has no likelihood.
    """
    if found.ended:
        return {}
    known = probabilities(found, decision)
    rows = [
        {"effects": [names[name] for name in sorted(effects)], "probability": each}
        for effects, each in known.effects.items()
        if effects and each >= PROBABILITY.shown
    ]
    return {
        "answer": of_answer(found, decision, known),
        "nothing": known.effects[NOTHING],
        "something_else": known.something_else,
        "effects": sorted(rows, key=lambda row: -row["probability"]),
    }
