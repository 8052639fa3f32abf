"""Which of several effects are missed where they are left out, and what could stand in for them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.gauss_newton import fitted, settled, wald
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.heldout import stands_on_heldout
from hannes.identification.diagnosis.like_faults import transferred
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import (
    Progress,
    faded,
    started_as_given,
    started_at_guess,
)
from hannes.identification.diagnosis.score_test import (
    Guess,
    amplitude_names,
    in_place_of,
    screened,
)
from hannes.identification.diagnosis.shape_rival import stands_against
from hannes.identification.diagnosis.trials import (
    Joint,
    SearchResult,
    Trial,
    joint_rivals,
    needed_beside,
    priced,
)
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.plants.part_fault import like_faults, part_faults


def pruned_effects(found: SearchResult, joint: Joint, progress: Progress) -> Joint:
    """The effects without those that are not missed; what is lost without each of the others.

    An effect may only have led the others out of a local minimum.
    """
    best, losses, without = joint.trial, dict(joint.losses), dict(joint.without)
    if len(best.effects) == 1:
        return joint
    missed = {name: _missed(found, best.point, name) for name in best.effects}
    for name in sorted(missed, key=lambda each: missed[each]):
        known = without.get(name)
        losses[name] = min([missed[name], *([best.delta_chi2 - known.delta_chi2] if known else [])])
        needed = needed_beside(best, found.variance_factor)
        if _surely_missed(best, missed[name], needed):
            continue
        less = left_out(found, best, name, progress)
        if less is not None and (known is None or less.delta_chi2 > known.delta_chi2):
            without[name] = known = less
        if known is not None:
            losses[name] = best.delta_chi2 - known.delta_chi2
            if _is_faint_fault(known, name, losses[name]) or not _is_missed(
                known, best, losses[name], found.variance_factor
            ):
                return pruned_effects(found, Joint(known), progress)
    return replace(joint, losses=losses, without=without)


def _surely_missed(best: Trial, missed: float, needed: float) -> bool:
    """Whether a removal costs many times as much as an effect needs, by the linearisation.

    It is believed up to what all effects explain together, and not beside a fault of one of like
    parts: what a fault does may be shared with a law, as much as with the machine.
    """
    enough = max(SEARCH.surely_missed, SEARCH.missed_much * needed)
    faults = part_faults(best.point.space.effects, best.effects)
    return enough < missed < best.delta_chi2 and not faults


def _is_missed(known: Trial, best: Trial, loss: float, variance_factor: float) -> bool:
    """Whether enough is lost without one effect; where it is little, by held-out runs as well."""
    if loss < needed_beside(known, variance_factor):
        return False
    return loss >= SEARCH.sure_beside or stands_on_heldout(known.point, best.point)


def _is_faint_fault(known: Trial, name: str, loss: float) -> bool:
    """Whether it is one of many like faults, little beside effects that leave noise without it.

    Twenty are tried, and one of them may follow what a fit of the others has not reached.
    """
    point = known.point
    if not part_faults(point.space.effects, [name]):
        return False
    return point.chi2 < point.residual.size and loss < SEARCH.second_share * known.delta_chi2


def _missed(found: SearchResult, point: Linearisation, name: str) -> float:
    """By how much the misfit would rise without an effect, were chi-squared quadratic."""
    space = point.space
    places = [space.place(each) for each in amplitude_names(space.effects[name])]
    return wald(point, places) / found.variance_factor


def left_out(found: SearchResult, joint: Trial, name: str, progress: Progress) -> Trial | None:
    """The other effects alone: one may only have led them there, or have kept them small.

    Refitted while it is removed gradually, and from the nominal machine at the sizes that they
    have beside it: the nominal machine is not biased by it.
    """
    kept = tuple(each for each in joint.effects if each != name)
    progress(f"{' and '.join(kept)} without {name}".replace("_", " "))
    gradually = faded(joint.point, name)
    fits = [settled(gradually)] if gradually is not None else []
    again = started_as_given(found.nominal, joint.point, kept)
    if again is not None:
        below = min([found.baseline.chi2, *(each.chi2 for each in fits)])
        fits.append(settled(fitted(again, 4), below=below))
    trials = [Trial(kept, each, 0.0) for each in fits]
    whole = [priced(found.baseline, each, found.variance_factor) for each in trials]
    return max(whole, key=lambda each: each.delta_chi2, default=None)


def with_rivals(found: SearchResult, progress: Progress) -> SearchResult:
    """The result with what could stand in for each of several effects, refitted in its place.

    A set that leaves less takes the place of the joint one.
    """
    joint = found.joint
    if joint is None:
        return found
    joint = _all_stand_ins(found, joint, progress)
    if (better := _promoted(found, joint, progress)) is not None:
        return with_rivals(replace(found, joint=better), progress)
    for rival in joint_rivals(joint):
        for name in joint.trial.effects:
            if name not in rival.effects:
                joint = _known_without(found, joint, name, progress)
    for name in joint.replaceable:
        joint = _known_without(found, joint, name, progress)
    return replace(found, joint=joint)


def _promoted(found: SearchResult, joint: Joint, progress: Progress) -> Joint | None:
    """A set that leaves less than the joint one, which is its rival then; None where none does."""
    best = max(joint.others, key=lambda each: each.delta_chi2, default=None)
    least = joint.trial.delta_chi2 + SEARCH.deeper
    if best is None or best.delta_chi2 <= least:
        return None
    others = (*(each for each in joint.others if each is not best), joint.trial)
    pruned = pruned_effects(found, Joint(best, others=others), progress)
    several = len(pruned.trial.effects) > 1 and pruned.trial.delta_chi2 > least
    return pruned if several else None


def _all_stand_ins(found: SearchResult, joint: Joint, progress: Progress) -> Joint:
    """The joint effects with what may stand in for each of them."""
    point, names = joint.trial.point, list(found.baseline.space.effects)
    guesses = screened(point, [name for name in names if name not in joint.trial.effects])
    for name in joint.trial.effects:
        linear = in_place_of(point, name, guesses)
        missed = _missed(found, point, name) * found.variance_factor
        free = [linear[each] for each in GENERIC if each in linear]
        most = max(free, key=lambda each: each.delta_chi2, default=None)
        if most is not None and most.delta_chi2 > missed - SEARCH.rival * found.variance_factor:
            if not _stands(found, joint.trial, name, most, progress):
                joint = replace(joint, replaceable={**joint.replaceable, name: most.effect})
        near = [each for each in linear.values() if each.effect not in GENERIC
                and each.delta_chi2 > SEARCH.stand_in_share * missed]  # fmt: skip
        near.sort(key=lambda each: -each.delta_chi2)
        joint = _with_stand_ins(found, joint, name, near[: SEARCH.stand_ins], progress)
        joint = _with_like_faults(found, joint, name, progress)
    return joint


def _with_like_faults(found: SearchResult, joint: Joint, name: str, progress: Progress) -> Joint:
    """The joint effects beside those with the same fault of another part, as large as it is.

    A linear estimate does not lead from one part's fault to another's.
    """
    trial, effects = joint.trial, joint.trial.point.space.effects
    tried = {frozenset(each.effects) for each in joint.others}
    kept = tuple(each for each in trial.effects if each != name)
    for other in like_faults(effects, name):
        if other in kept or {*kept, other} in tried:
            continue
        progress(f"{other} instead of {name}".replace("_", " "))
        point = transferred(found.baseline, trial.point, name, other)
        if point is not None:
            rival = Trial((*kept, other), point, 0.0)
            rival = priced(found.baseline, rival, found.variance_factor)
            joint = replace(joint, others=(*joint.others, rival))
    return joint


def _with_stand_ins(
    found: SearchResult, joint: Joint, name: str, others: Sequence[Guess], progress: Progress
) -> Joint:
    """The joint effects beside those with another one in the place of one of them."""
    tried = {frozenset(each.effects) for each in joint.others}
    kept = {each for each in joint.trial.effects if each != name}
    for guess in others:
        if kept | {guess.effect} not in tried:
            rival = _instead(found, joint.trial, name, guess, progress)
            joint = replace(joint, others=(*joint.others, rival)) if rival else joint
    return joint


def _instead(
    found: SearchResult, trial: Trial, name: str, guess: Guess, progress: Progress
) -> Trial | None:
    """The effects with another one in the place of one of them, refitted; None where that fails."""
    progress(f"{guess.effect} instead of {name}".replace("_", " "))
    point, own = trial.point, trial.point.space.of(name)
    x = np.where(np.isin(np.arange(point.x.size), own), 0.0, point.x)
    start = point.with_active(np.setdiff1d(point.active, own)).moved(x, np.zeros(0, int))
    begun = start and started_at_guess(start, guess)
    if begun is None:
        return None
    kept = tuple(each for each in trial.effects if each != name)
    rival = Trial((*kept, guess.effect), settled(fitted(begun, 4)), 0.0)
    return priced(found.baseline, rival, found.variance_factor)


def _stands(found: SearchResult, trial: Trial, name: str, shape: Guess, progress: Progress) -> bool:
    """Whether an effect stands against a generic disturbance that linearly does as much.

    Not where that cannot be refitted. Where the bound of work ended the search, there is no work
    for that, and the linear prediction decides.
    """
    if found.cut_short:
        return False
    generic = _instead(found, trial, name, shape, progress)
    return generic is not None and stands_against(found, trial, generic)


def _known_without(found: SearchResult, joint: Joint, name: str, progress: Progress) -> Joint:
    if name in joint.without:
        return joint
    less = left_out(found, joint.trial, name, progress)
    return replace(joint, without={**joint.without, name: less}) if less else joint
