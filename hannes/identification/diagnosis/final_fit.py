"""The final fit of the effects named: their sizes and how certain they are.

Many fits are compared to find the effects, in bins that every machine can be simulated in, and
with the noise of a machine without effects. Afterwards one machine is left. Its discretisation
error is simulated with the effects in it, and the bins are finer. It decides between no rivals.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.gauss_newton import fitted, settled, standard_deviations
from hannes.identification.diagnosis.linearisation import Linearisation, begun
from hannes.identification.diagnosis.noise_covariance import NoiseAccuracy
from hannes.identification.diagnosis.profile_likelihood import held_at, profile
from hannes.identification.diagnosis.pruning import pruned
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.tuning import FIT
from hannes.identification.diagnosis.work_bound import SearchEnded


@dataclass(frozen=True)
class FinalFit:
    """A fit, and the standard deviation of each fitted parameter, by index, in steps.

    cut_short: whether it is that of the search, as the bound of work ended a finer one
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

    So it is where the bound of work ends them. variance_factor: by which chi-squared is divided
    """
    try:
        return _refined(point, effects, accuracy, seed, variance_factor)
    except SearchEnded:
        return FinalFit(point, _linear(point), cut_short=True)


def _linear(point: Linearisation) -> dict[int, float]:
    """Standard deviation of each fitted parameter by the linearisation, widened."""
    widened = FIT.linear_widening * standard_deviations(point)
    return dict(zip(point.active.tolist(), widened.tolist(), strict=True))


def _refined(
    point: Linearisation,
    effects: Sequence[str],
    accuracy: NoiseAccuracy,
    seed: int,
    variance_factor: float,
) -> FinalFit:
    fine = _finer(point, effects, accuracy, seed)
    if fine is not point:
        fine = pruned(fine, effects, variance_factor)
    spread = _linear(fine)
    places = np.intersect1d(fine.space.of(*effects), fine.active)
    if fine is point or not places.size:
        return FinalFit(point, spread)
    found = {k: profile(fine, k, spread[k] / FIT.linear_widening) for k in map(int, places)}
    known = {k: each for k, each in found.items() if each is not None}
    start = min([fine, *(each.lowest for each in known.values())], key=lambda each: each.chi2)
    values = [known[k].least if k in known else fine.x[k] for k in found]
    minimum = held_at(start, places, np.array(values))
    if (
        minimum is None
        or minimum.chi2 > fine.chi2 + FIT.local_minima * places.size
        or not _runs(minimum)
    ):
        return FinalFit(fine, spread)  # least along each parameter, but not along all together
    return FinalFit(minimum, spread | {k: each.deviation for k, each in known.items()})


def _finer(
    point: Linearisation, effects: Sequence[str], accuracy: NoiseAccuracy, seed: int
) -> Linearisation:
    """The fit converged in finer bins; unchanged where that cannot be simulated."""
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
        return point
    fine = settled(fitted(there, 4))
    return fine if _runs(fine) else point


def _runs(point: Linearisation) -> bool:
    """Whether every command can be simulated there with the sampled controller."""
    model, rows = point.model, point.x[np.newaxis]
    runs = (model.simulated(group, rows, True, exact=True)[0] for group in model.groups)
    return all(run is not None for run in runs)
