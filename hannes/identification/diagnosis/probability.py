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
    trials, scale = _tried(found), found.variance_factor
    price = PROBABILITY.first_price
    gains = {effects: scale * each.delta_chi2 - price for effects, each in trials.items()}
    gains[NOTHING] = 0.0
    best = max(gains, key=lambda effects: gains[effects])
    count = max(1, len(found.guesses))
    logs = {
        effects: math.log(_expected(effects, count))
        + (gain - gains[best]) / _temper(_apart(found, best, effects) * scale, _law_error(found))
        for effects, gain in gains.items()
    }
    # Where several effects are found, something else is as much to expect as one of them.
    several = _expected(best, count) / _expected(frozenset(sorted(best)[:1]), count)
    more = (_of_any_shape(found, scale) - gains[best]) / _temper(gains[best] + price)
    everything = _normalised(logs, math.log(PROBABILITY.something_else * several) + more)
    if decision.kind in ("no_gap", "recalibrated"):
        return _with_nothing(everything)
    return _disbelieved(everything) if decision.kind == "unknown" else everything


def _expected(effects: frozenset[str], count: int) -> float:
    """Probability of a set of effects before any recording, in a catalogue of so many."""
    if not effects:
        return PROBABILITY.nothing
    one = (1.0 - PROBABILITY.nothing - PROBABILITY.something_else) / count
    return one * (PROBABILITY.further / count) ** (len(effects) - 1)


def _apart(found: SearchResult, best: frozenset[str], effects: frozenset[str]) -> float:
    """What those of the best effects explain that another set lacks."""
    losses = found.joint.losses if found.joint else {}
    whole = found.best.delta_chi2 if found.best else 0.0
    return sum(max(0.0, losses.get(name, whole)) for name in sorted(best - effects))


def _law_error(found: SearchResult) -> float:
    """Chi-squared by which the best laws may be wrong at most: what they leave above noise.

    At least the standard deviation of what noise leaves.
    """
    point = found.best.point if found.best else found.baseline
    return max(point.chi2 - found.bins, math.sqrt(2.0 * found.bins))


def _temper(explained: float, most: float = math.inf) -> float:
    """By what differences count, as laws err by a share of what they explain; 2 where by none.

    most: chi-squared by which they may be wrong at most
    """
    return 2.0 * max(1.0, min(PROBABILITY.law_error * explained, most))


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


def _of_any_shape(found: SearchResult, scale: float) -> float:
    """What a law of any shape lowers chi-squared by, less its price.

    It takes what the best effects do and leave above noise, but for what a right law leaves too.
    """
    point = found.best.point if found.best else found.baseline
    best = scale * max(0.0, found.best.delta_chi2) if found.best else 0.0
    left = max(0.0, point.chi2 - found.bins)
    generic = scale * found.generic.delta_chi2 if found.generic else 0.0
    whole = max(best + left - PROBABILITY.law_share * best, generic)
    return whole - PROBABILITY.shape_price


def _normalised(logs: Mapping[frozenset[str], float], other: float) -> Probabilities:
    most = max([other, *logs.values()])
    total = math.exp(other - most) + sum(math.exp(each - most) for each in logs.values())
    return Probabilities(
        {effects: math.exp(each - most) / total for effects, each in logs.items()},
        math.exp(other - most) / total,
    )


def _with_nothing(known: Probabilities) -> Probabilities:
    """The same where nothing is missing by the verdict, which has a least part: an effect that
    gains too little for a name is chance more often than its likelihood says.
    """
    nothing = max(known.effects[NOTHING], PROBABILITY.least_nothing)
    share = (1.0 - nothing) / max(1.0 - known.effects[NOTHING], 1e-12)
    others = {e: share * each for e, each in known.effects.items() if e}
    return Probabilities({NOTHING: nothing, **others}, share * known.something_else)


def _disbelieved(known: Probabilities) -> Probabilities:
    """The same where no effect is believed: some of what effects have goes to something else.

    What made it unknown may be in no likelihood (one place, one channel), so it has a least part.
    """
    kept = {e: PROBABILITY.refused * each for e, each in known.effects.items() if e}
    taken = sum(each for e, each in known.effects.items() if e) - sum(kept.values())
    other = known.something_else + taken
    share = max(0.0, PROBABILITY.least_else - other) / (1.0 - other) if other < 1.0 else 0.0
    every = {NOTHING: known.effects[NOTHING], **kept}
    return Probabilities(
        {e: (1.0 - share) * each for e, each in every.items()}, other + share * sum(every.values())
    )


def of_answer(found: SearchResult, decision: Decision, known: Probabilities) -> float:
    """Probability that the verdict is right.

    Of effects with a remainder, that those are there, whatever else is.
    """
    named = frozenset(decision.effects)
    if decision.kind in ("no_gap", "recalibrated"):
        return known.effects[NOTHING]
    if decision.kind == "one_of":
        # A set has another order in each process: added up exactly, every one gives the same bits.
        return math.fsum(known.effects.get(frozenset({name}), 0.0) for name in named)
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
