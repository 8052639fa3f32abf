"""The final fit of the effects named: their sizes and how certain they are.

Many fits are compared to find the effects, in bins that every machine can be simulated in, and
with the noise of a machine without effects. Afterwards one machine is left. Its discretisation
error is simulated with the effects in it, and the bins are finer. It decides between no rivals.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.gauss_newton import fitted, rounds, standard_deviations
from hannes.identification.diagnosis.linearisation import Linearisation, begun
from hannes.identification.diagnosis.noise_covariance import NoiseAccuracy
from hannes.identification.diagnosis.profile_likelihood import Profile, held_at, profile
from hannes.identification.diagnosis.pruning import pruned
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.tuning import FIT
from hannes.identification.diagnosis.work_bound import SearchEnded


@dataclass(frozen=True)
class FinalFit:
    """A fit, and the standard deviation of each fitted parameter, by index, in steps.

    cut_short: whether the bound of work ended it: what was reached by then stands
    """

    point: Linearisation
    deviations: dict[int, float]
    cut_short: bool = False


def final_fit(
    point: Linearisation,
    effects: Sequence[str],
    accuracy: NoiseAccuracy,
    seed: int,
    variance_factor: float = 1.0,
) -> FinalFit:
    """The fit in finer bins, at the minimum of its profiles; unchanged where these fail.

    Where the bound of work ends it, as far as it came. variance_factor: by which chi-squared is
    divided
    """
    try:
        fine, ended = _finer(point, effects, accuracy, seed)
    except SearchEnded:
        return FinalFit(point, _linear(point), cut_short=True)
    if fine is point:
        return FinalFit(point, _linear(point), ended)
    try:
        fine = pruned(fine, effects, variance_factor)
    except SearchEnded:
        return FinalFit(fine, _linear(fine), cut_short=True)
    found = _at_profiles(fine, effects)
    return replace(found, cut_short=ended or found.cut_short)


def _linear(point: Linearisation) -> dict[int, float]:
    """Standard deviation of each fitted parameter by the linearisation, widened."""
    widened = FIT.linear_widening * standard_deviations(point)
    return dict(zip(point.active.tolist(), widened.tolist(), strict=True))


def _at_profiles(fine: Linearisation, effects: Sequence[str]) -> FinalFit:
    """The fit at the minimum of the profiles of all sizes; itself where they have none together."""
    spread, known = _linear(fine), dict[int, Profile]()
    cut_short, minimum = False, None
    places = np.intersect1d(fine.space.of(*effects), fine.active)
    try:
        for place in map(int, places):
            if found := profile(fine, place, spread[place] / FIT.linear_widening):
                known[place] = found
        minimum = _least_together(fine, places, known)
    except SearchEnded:
        cut_short = True
    if minimum is None and not cut_short:
        return FinalFit(fine, spread)  # least along each parameter, but not along all together
    deviations = spread | {k: each.deviation for k, each in known.items()}
    lowest = min([fine, *(each.lowest for each in known.values())], key=lambda each: each.chi2)
    return FinalFit(minimum or (lowest if _runs(lowest) else fine), deviations, cut_short)


def _least_together(
    fine: Linearisation, places: np.ndarray, known: Mapping[int, Profile]
) -> Linearisation | None:
    """The fit with each size where its profile is least; None where it is above, or cannot run."""
    if not places.size:
        return None
    start = min([fine, *(each.lowest for each in known.values())], key=lambda each: each.chi2)
    values = [known[k].least if k in known else fine.x[k] for k in map(int, places)]
    minimum = held_at(start, places, np.array(values))
    if minimum is None or minimum.chi2 > fine.chi2 + FIT.local_minima * places.size:
        return None
    return minimum if _runs(minimum) else None


def _finer(
    point: Linearisation, effects: Sequence[str], accuracy: NoiseAccuracy, seed: int
) -> tuple[Linearisation, bool]:
    """The fit converged in finer bins, unchanged where that cannot run; whether it was ended."""
    model = point.model
    held = model.held([Group(model.small, each.entries, FIT.finer_bins) for each in model.groups])
    try:
        there = begun(
            held.with_sampling_correction(point.x, effects),
            point.x,
            point.active,
            accuracy,
            seed,
            point.noise.parts,
        )
    except ComputationFailed:
        return point, False
    fine, ended = _settled_while_allowed(there)
    return (fine if _runs(fine) else point), ended


def _settled_while_allowed(point: Linearisation) -> tuple[Linearisation, bool]:
    """The fit converged, or as far as the bound of work lets it; whether that ended it."""
    try:
        point = fitted(point, 4)
        for further in rounds(point):
            point = further
    except SearchEnded:
        return point, True
    return point, False


def _runs(point: Linearisation) -> bool:
    """Whether every command can be simulated there with the sampled controller."""
    model, rows = point.model, point.x[np.newaxis]
    with model.work.in_any_case():
        made = [model.simulated(group, rows, True, exact=True)[0] for group in model.groups]
    return all(run is not None for run in made)
