"""Trials of effects and what a search found, ordered by their reduction of chi-squared."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hannes.identification.diagnosis.gauss_newton import settled, wald
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.noise_scale import estimated_variance_factor
from hannes.identification.diagnosis.score_test import Guess, amplitude_names, cosine_similarity
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.plants.part_fault import like_faults, part_faults


@dataclass(frozen=True)
class Trial:
    """Effects refitted together.

    delta_chi2: chi-squared of the baseline less the trial's, less the price of its parameters
    confusable: effects whose signatures these recordings hardly separate from the first one's
    """

    effects: tuple[str, ...]
    point: Linearisation = field(repr=False)
    delta_chi2: float
    confusable: tuple[str, ...] = ()

    @property
    def numbers(self) -> int:
        """How many parameters its effects have."""
        return int(self.point.space.of(*self.effects).size)


@dataclass(frozen=True)
class Joint:
    """Several effects refitted together, where one is not enough.

    without: the others refitted alone, by the effect that is left out, where that was tried
    losses: by how much less chi-squared is reduced without each effect, all else following
    others: as many effects, some of them other ones
    replaceable: effect -> a generic disturbance against which it does not stand, in its place
    """

    trial: Trial
    without: Mapping[str, Trial] = field(default_factory=dict)
    losses: Mapping[str, float] = field(default_factory=dict)
    others: tuple[Trial, ...] = ()
    replaceable: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class SearchResult:
    """Everything that a search found.

    nominal, baseline: the machine as given and refitted;  trials: single effects, best first
    guesses: of the whole catalogue, linear, at the baseline
    joint: several effects, where one is not enough
    remaining: the best guess for what is left after the last of them
    variance_factor: variance of the noise over the assumed one, by which chi-squared is divided
    generic: the best generic disturbance, where a guess makes one worth fitting
    ended: what ended the search before its end, in words, or ""
    asked: the fit from which a better baseline was looked for in vain
    cut_short: whether the search for further effects was ended, or the one beside a better
               baseline: what was found by then stands
    """

    nominal: Linearisation
    baseline: Linearisation
    guesses: list[Guess]
    trials: list[Trial]
    joint: Joint | None
    remaining: Guess | None
    variance_factor: float
    generic: Trial | None = None
    ended: str = ""
    cut_short: bool = False
    asked: Linearisation | None = None

    @property
    def bins(self) -> int:
        """How many values are compared."""
        return self.baseline.residual.size

    @property
    def best(self) -> Trial | None:
        """The effects that explain most: several, where one is not enough."""
        if self.joint:
            return self.joint.trial
        return self.trials[0] if self.trials else None


def priced(baseline: Linearisation, trial: Trial, variance_factor: float) -> Trial:
    """The trial with its reduction of chi-squared, less what a name of its parameters costs."""
    faults = part_faults(trial.point.space.effects, trial.effects)
    paid = sum(_further_numbers(trial.point, each) for each in trial.effects)
    paid += SEARCH.fault_price * len(faults)
    paid += SEARCH.simulated_price * baseline.noise.simulated_noise
    paid -= sum(_spared(trial.point, name, variance_factor) for name in faults)
    lowered = (baseline.chi2 - trial.point.chi2) / variance_factor
    return replace(trial, delta_chi2=lowered - paid)


def _further_numbers(point: Linearisation, name: str) -> float:
    """What the numbers of an effect beyond its first cost."""
    price = SEARCH.generic_price if name in GENERIC else SEARCH.parameter_price
    return price * (point.space.of(name).size - 1)


def _spared(point: Linearisation, name: str, variance_factor: float) -> float:
    """What an effect need not pay for its second number: by the first alone less may be lost."""
    names = amplitude_names(point.space.effects[name])
    if len(names) < 2:
        return 0.0
    lost = min(wald(point, [point.space.place(each)]) for each in names) / variance_factor
    return max(0.0, SEARCH.parameter_price - lost)


def converged(baseline: Linearisation, trial: Trial, variance_factor: float) -> Trial:
    """The trial with its fit converged: its parameters are reported."""
    return priced(baseline, replace(trial, point=settled(trial.point)), variance_factor)


def needed_beside(trial: Trial, variance_factor: float) -> float:
    """Reduction that one more effect needs beside these, whose laws are never quite right.

    What they leave bounds by how much they are wrong: one that explains most of it is there.
    """
    beyond = (trial.point.chi2 - trial.point.residual.size) / variance_factor
    most = max(SEARCH.sure_beside, SEARCH.share_of_rest * beyond)
    return max(SEARCH.name_limit, min(SEARCH.further_share * trial.delta_chi2, most))


def scaled(found: SearchResult, least: Linearisation) -> SearchResult:
    """The result with its noise scaled by a better fit, and every reduction with it."""
    variance_factor = estimated_variance_factor(found.baseline, least.chi2)
    if variance_factor >= found.variance_factor:
        return found
    trials = [priced(found.baseline, each, variance_factor) for each in found.trials]
    generic = found.generic and priced(found.baseline, found.generic, variance_factor)
    return replace(found, trials=trials, generic=generic, variance_factor=variance_factor)


def may_be_named(found: SearchResult) -> bool:
    """Whether the best effect reduces chi-squared enough for a name."""
    return bool(found.trials) and found.trials[0].delta_chi2 > SEARCH.name_limit


def best_first(trials: Sequence[Trial]) -> list[Trial]:
    """The trials by their reduction, the largest first."""
    return sorted(trials, key=lambda each: -each.delta_chi2)


def near(best: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """The trials that these recordings do not separate from the best one."""
    return [
        each
        for each in trials
        if each.effects != best.effects
        and best.delta_chi2 - _at_its_best(each) < _far(best, each, best.delta_chi2)
    ]


def _at_its_best(trial: Trial) -> float:
    """A trial's reduction, were a number free that it does not need.

    An effect of two numbers, one of which is nothing here, is no less likely for the other.
    """
    if len(trial.effects) > 1 or trial.effects[0] in GENERIC:
        return trial.delta_chi2
    if part_faults(trial.point.space.effects, trial.effects):  # it is in their price
        return trial.delta_chi2
    return trial.delta_chi2 + _spared(trial.point, trial.effects[0], 1.0)


def joint_rivals(joint: Joint) -> list[Trial]:
    """The other sets of effects that these recordings do not separate from the joint ones.

    What counts is what those effects explain in which the two sets differ.
    """
    best, found = joint.trial, list[Trial]()
    for each in joint.others:
        apart = set(best.effects) - set(each.effects)
        explained = sum(joint.losses.get(name, best.delta_chi2) for name in apart)
        if apart and best.delta_chi2 - each.delta_chi2 < _far(best, each, explained):
            found.append(each)
    return found


def _far(best: Trial, other: Trial, explained: float) -> float:
    """Reduction of chi-squared by which another trial is separated from the best one.

    Laws are inexact by a share of what they explain. Where the best one leaves little, its law is
    right, and one that leaves much more is another; the same fault of two parts is one law. What
    noise leaves is known to its standard deviation alone.
    """
    if _same_laws(best, other):
        return SEARCH.rival
    bins = best.point.residual.size
    left = max(SEARCH.left_again * (best.point.chi2 - bins), float(np.sqrt(2.0 * bins)))
    return max(SEARCH.rival, min(SEARCH.rival_share * explained, left))


def _same_laws(one: Trial, other: Trial) -> bool:
    """Whether two trials differ in the part that has a fault alone."""
    apart = set(one.effects) ^ set(other.effects)
    if len(one.effects) != len(other.effects) or len(apart) != 2:
        return False
    first, second = apart
    return second in like_faults(one.point.space.effects, first)


def with_confusable(
    baseline: Linearisation, guesses: Sequence[Guess], trials: list[Trial]
) -> list[Trial]:
    """The trials, each with the effects whose signatures are hardly separated from its own."""
    signatures = {guess.effect: guess.signature for guess in guesses}
    return [
        replace(
            each,
            confusable=tuple(
                name
                for name in signatures
                if name != each.effects[0]
                and cosine_similarity(baseline, signatures[each.effects[0]], signatures[name])
                > SEARCH.confusable_cosine
            ),
        )
        for each in trials
    ]
