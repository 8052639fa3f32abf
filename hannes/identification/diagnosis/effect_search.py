"""Searches for what is missing: baseline, single effects beside it, then further ones."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.core.effect import Effect
from hannes.identification.diagnosis.as_given import AsGiven
from hannes.identification.diagnosis.baseline import based, lost
from hannes.identification.diagnosis.better_baseline import better_baseline
from hannes.identification.diagnosis.further_effects import with_further_effects
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import (
    Fits,
    Progress,
    without,
)
from hannes.identification.diagnosis.noise_at_best import waits, with_noise_at_best
from hannes.identification.diagnosis.order_of_runs import in_order
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.single_effects import (
    looked_at,
    promises_all,
    searched_beside,
    stands,
)
from hannes.identification.diagnosis.small_gains import with_small_gains
from hannes.identification.diagnosis.trials import (
    SearchResult,
    Trial,
    may_be_named,
)
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded, Work
from hannes.plants.protocol import Plant


def search_effects(
    plant: Plant,
    entries: Sequence[Entry],
    effects: Sequence[Effect],
    settings: Settings,
    seed: int,
    progress: Progress = lambda text: None,
    work: Work | None = None,
) -> SearchResult:
    """Search for what is missing; ComputationFailed where the baseline cannot be simulated.

    work: what was spent before, and the limit of all
    """
    work = work or Work(bounded=True)
    groups = in_order(grouped(plant, entries), effects)
    nominal, baseline = based(plant, groups, settings, effects, seed, progress, work)
    try:
        return _all_searched(nominal, baseline, effects, seed, progress)
    except SearchEnded:
        return SearchResult(nominal, baseline, [], [], None, None, 1.0, ended=work.ended)


def _all_searched(
    nominal: Linearisation,
    baseline: Linearisation,
    effects: Sequence[Effect],
    seed: int,
    progress: Progress,
) -> SearchResult:
    """Single effects beside the best baseline, then further ones."""
    given = AsGiven(nominal, baseline, [e.name for e in effects if e.name not in GENERIC])
    beside, known, looked = baseline, dict[str, Linearisation](), looked_at(baseline, progress)
    if lost(baseline) and not promises_all(baseline, looked):
        known = given.global_fits(baseline, progress)
        beside = _beside_best(baseline, known)
    looked = looked if beside is baseline else []
    found = searched_beside(beside, given, known, progress, looked)
    found = _beside_better(given, found, known, progress)
    if baseline.chi2 < found.baseline.chi2:
        found = _rebased(found, baseline)
    return found if found.cut_short else _with_further(found, seed, progress)


def _beside_better(
    given: AsGiven, found: SearchResult, known: Fits, progress: Progress
) -> SearchResult:
    """The result beside the baseline that its best effect leads to, where that is a better one.

    Searched again while it is much better. Where the bound of work ends that, the fits of the
    search before stand beside it. The first such baseline is then asked for in work of its own, but
    where the best effect explains all.
    """
    if found.cut_short:
        return found
    led = np.zeros(0)
    try:
        while (leader := _leading(found)) and not np.array_equal(leader.point.x, led):
            if leader.point is found.asked:
                break
            better = better_baseline(
                found.baseline, leader.point, leader.effects, found.variance_factor, progress
            )
            if better is None:
                break
            led, less = leader.point.x, found.baseline.chi2 - better.chi2
            fits = {each.effects[0]: each.point for each in found.trials}
            found = _rebased(found, better)
            if less < SEARCH.second_share * leader.delta_chi2 * found.variance_factor:
                break
            found = searched_beside(better, given, {**known, **fits}, progress)
            if found.cut_short:
                break
    except SearchEnded:
        if not may_be_named(found):
            raise
        found.baseline.model.work.extended()
        fits = {each.effects[0]: each.point for each in found.trials}
        if not led.size and not stands(found.baseline, fits):
            found = _asked_again(found, progress)
        return replace(found, cut_short=True)
    return found


def _asked_again(found: SearchResult, progress: Progress) -> SearchResult:
    """The result beside the baseline that its best effect leads to, where that was not asked.

    SearchEnded where that takes too much, and where nothing may be named beside it: candidates
    would have to be searched beside it again.
    """
    best, factor = found.trials[0], found.variance_factor
    better = better_baseline(found.baseline, best.point, best.effects, factor, progress)
    again = found if better is None else _rebased(found, better)
    if not may_be_named(again):
        raise SearchEnded
    return again


def _beside_best(baseline: Linearisation, known: Fits) -> Linearisation:
    """The baseline; where it is lost, the machine of the best global fit, without its effect."""
    best = min(known.items(), key=lambda each: each[1].chi2, default=None)
    if best is None or not lost(baseline):
        return baseline
    return baseline.moved(without(best[1], [best[0]])[0], baseline.active) or baseline


def _with_further(found: SearchResult, seed: int, progress: Progress) -> SearchResult:
    """With further effects; single ones alone where the bound of work ends that search.

    What judges and closes them then has some work of its own.
    """
    try:
        found = found if waits(found) else with_noise_at_best(found, seed, progress)
        found = with_small_gains(found, progress)
        return with_further_effects(found, seed, progress) if may_be_named(found) else found
    except SearchEnded:
        found.baseline.model.work.extended()
        return replace(found, cut_short=True)


def _leading(found: SearchResult) -> Trial | None:
    """The trial that improved the fit most: one that may be named, else any."""
    every = [*found.trials[:1], *([found.generic] if found.generic else [])]
    named = found.trials[:1] if may_be_named(found) else every
    best = max(named, key=lambda each: each.delta_chi2, default=None)
    return best if best is not None and best.delta_chi2 > SEARCH.faint else None


def _rebased(found: SearchResult, baseline: Linearisation) -> SearchResult:
    """The same result beside a better baseline: every reduction shrinks by that."""
    less = (found.baseline.chi2 - baseline.chi2) / found.variance_factor
    trials = [
        replace(each, delta_chi2=each.delta_chi2 - less)
        for each in found.trials
        if each.point.chi2 < baseline.chi2
    ]
    generic = found.generic and replace(found.generic, delta_chi2=found.generic.delta_chi2 - less)
    return replace(found, baseline=baseline, trials=trials, generic=generic)
