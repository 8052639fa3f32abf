"""The nominal machine and the baseline fit, against which every effect is compared."""

from collections.abc import Sequence

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.core.recording.white_noise import rounding
from hannes.identification.diagnosis.gauss_newton import fitted, relinearised, settled
from hannes.identification.diagnosis.linearisation import Linearisation, first, with_noise
from hannes.identification.diagnosis.multistart import Progress
from hannes.identification.diagnosis.noise_colour import noise_bandwidth
from hannes.identification.diagnosis.noise_covariance import (
    NoiseAccuracy,
    NoiseCovariance,
    estimated_noise,
)
from hannes.identification.diagnosis.noise_model import recorded_roughness
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.part_deviations import part_deviations
from hannes.identification.diagnosis.parts_as_fitted import (
    about,
    leaves_noise,
    with_parts_as_fitted,
)
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.run_to_run import settings_from_repeats
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.tuning import NOISE, SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded, Work
from hannes.plants.protocol import Plant

COARSE = NoiseAccuracy(NOISE.coarse_nonlinearity, NOISE.coarse_samples)
FINE = NoiseAccuracy(NOISE.fine_nonlinearity, NOISE.fine_samples)
ROUGH = NoiseAccuracy(NOISE.fine_nonlinearity, NOISE.coarse_samples)
Fits = tuple[Linearisation, Linearisation]


def based(
    plant: Plant,
    groups: Sequence[Group],
    settings: Settings,
    effects: Sequence[Effect],
    seed: int,
    progress: Progress,
    work: Work | None = None,
) -> tuple[Linearisation, Linearisation]:
    """The nominal and the refitted machine; the nominal one twice where `work` ends the fit.

    Fitted once more where repeats show more run-to-run variability than the settings assume. A lost
    baseline does not show that: noise about it is not the machine's.
    """

    bandwidth = noise_bandwidth(plant, groups)

    def model(settings: Settings) -> Model:
        space = ParameterSpace(plant, groups, settings, effects)
        return Model(plant, groups, space, effects, work, bandwidth)

    nominal, baseline = _fits(model(settings), seed, progress)
    shown = settings if lost(baseline) else settings_from_repeats(baseline.noise, settings)
    if shown != settings:
        return _fits(model(shown), seed, progress, baseline)
    return nominal, baseline


def _fits(model: Model, seed: int, progress: Progress, near: Linearisation | None = None) -> Fits:
    """The nominal machine and the baseline fit, with noise estimated at the baseline.

    near: a fit by other settings, from where this one starts
    """
    progress("the machine as given")
    with model.work.in_any_case():
        nominal = first(model, COARSE, seed)
    _require_answers(nominal)
    progress("the baseline")
    try:
        return _refitted(nominal, seed, near)
    except SearchEnded:
        return nominal, nominal


def _refitted(nominal: Linearisation, seed: int, near: Linearisation | None) -> Fits:
    """The nominal machine and the baseline fit, by the noise at the baseline.

    That is estimated roughly first: contacts change with the baseline, and with them the noise. A
    lost baseline is no machine that there is. It is not followed further, and noise is that of the
    machine as given.
    """
    model, baseline = nominal.model, (near and _begun_at(nominal, near)) or _begun(nominal)
    if lost(baseline):
        noise = _noise_at(nominal, seed)
        return with_noise(nominal, noise), with_noise(baseline, noise)
    corrected = model.with_sampling_correction(baseline.x, list(model.space.effects))
    parts = part_deviations(corrected, baseline.x)
    for accuracy in (ROUGH, FINE):
        noise = estimated_noise(corrected, baseline.x, accuracy, seed, parts)
        baseline = fitted(with_noise(baseline, noise), 4)
    return _with_parts(nominal, baseline)


def _with_parts(nominal: Linearisation, baseline: Linearisation) -> Fits:
    """Both about the machine with its parts as the baseline has them, where it leaves little."""
    stays = with_noise(nominal, baseline.noise)
    try:
        found = with_parts_as_fitted(baseline) if leaves_noise(baseline) else None
        if found is None:
            return stays, settled(baseline)
        if not found.model.parts_at:
            return stays, found
        given = about(nominal, found.noise)
    except SearchEnded:
        return stays, baseline
    return (given, found) if given else (stays, baseline)


def _begun(nominal: Linearisation) -> Linearisation:
    """Some steps from the machine as given, and more by new derivatives; fewer to a lost one."""
    point = fitted(nominal, 2)
    point = point if lost(point) else fitted(point, 3)
    return point if lost(point) else fitted(relinearised(point), 5)


def _begun_at(nominal: Linearisation, near: Linearisation) -> Linearisation | None:
    """Some steps from where a fit by other settings ended; None where that fails, or is lost."""
    known = nominal.space.uncertain
    values = [near.space.parameters[k].value(near.x[k]) for k in known]
    x = nominal.x.copy()
    x[known] = [nominal.space.parameters[k].x(float(v)) for k, v in zip(known, values, strict=True)]
    there = nominal.moved(np.clip(x, nominal.space.low, nominal.space.high), nominal.active)
    point = there and fitted(there, 5)
    return None if point is None or lost(point) else point


def lost(baseline: Linearisation) -> bool:
    """Whether a fit leaves far too much, although values of the machine went far away.

    Where derivatives take little work, it is followed to its end all the same.
    """
    if baseline.model.round_of_derivatives() < SEARCH.little_work:
        return False
    per_bin, far = baseline.chi2 / baseline.residual.size, np.abs(baseline.x).max()
    return bool(per_bin > SEARCH.lost_baseline and far > SEARCH.far_away)


def _noise_at(nominal: Linearisation, seed: int) -> NoiseCovariance:
    """Noise of the machine as given."""
    model, x = nominal.model, nominal.x
    corrected = model.with_sampling_correction(x, list(model.space.effects))
    return estimated_noise(corrected, x, FINE, seed, part_deviations(corrected, x))


def _require_answers(nominal: Linearisation) -> None:
    """Raise BadInput for a channel that stays zero whatever the machine's values are nearby.

    No fit leads from there, and what is recorded would all look like something missing.
    """
    groups = zip(nominal.model.groups, nominal.vectors, nominal.derivatives, strict=True)
    for group, vector, derivatives in groups:
        for name in group.names:
            place = group.of(name)
            silent = not vector[place].any() and not derivatives[:, place].any()
            if silent and _surely_alive(nominal.model.groups, group, name):
                raise BadInput(
                    f"{group.entries[0].name}: the simulated {name} is zero throughout, whatever "
                    "the machine's values are nearby, and the recorded one is not: set base, or "
                    f"the experiment's object, to what is nearer, or leave the {name} out"
                )


def _surely_alive(groups: Sequence[Group], group: Group, name: str) -> bool:
    """Whether a recorded channel moves beyond noise, and not little beside where it moves most.

    Noise is what its samples differ by from one to the next, a sensor's rounding, or what repeats
    of any command differ by: a load cell at rest drifts.
    """
    there = [each for each in groups if name in each.names]
    coarse = max(rounding(view.samples(name)) for view in group.views)
    apart = [float(np.sqrt(np.mean(np.var(e.measured[:, e.of(name)], axis=0, ddof=1))))
             for e in there if e.count > 1]  # fmt: skip
    noise = max(recorded_roughness(group)[name], coarse)
    moves = float(np.ptp(group.mean[group.of(name)]))
    most = max(float(np.ptp(each.mean[each.of(name)])) for each in there)
    return moves > max(NOISE.alive * noise, NOISE.apart * max(apart, default=0.0),
                       NOISE.beside * most)  # fmt: skip
