"""The nominal machine and the baseline fit, against which every effect is compared."""

from collections.abc import Sequence

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.core.recording.white_noise import rounding
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation, first, with_noise
from hannes.identification.diagnosis.multistart import Progress
from hannes.identification.diagnosis.noise_covariance import NoiseAccuracy, estimated_noise
from hannes.identification.diagnosis.noise_model import recorded_roughness
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.part_deviations import part_deviations
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.run_to_run import settings_from_repeats
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.tuning import NOISE
from hannes.identification.diagnosis.work_bound import SearchEnded, Work
from hannes.plants.protocol import Plant

COARSE = NoiseAccuracy(NOISE.coarse_nonlinearity, NOISE.coarse_samples)
FINE = NoiseAccuracy(NOISE.fine_nonlinearity, NOISE.fine_samples)


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

    Fitted once more where repeats show more run-to-run variability than the settings assume.
    """

    def model(settings: Settings) -> Model:
        return Model(plant, groups, ParameterSpace(plant, groups, settings, effects), effects, work)

    nominal, baseline = _fitted(model(settings), seed, progress)
    if (shown := settings_from_repeats(baseline.noise, settings)) != settings:
        return _fitted(model(shown), seed, progress)
    return nominal, baseline


def _fitted(model: Model, seed: int, progress: Progress) -> tuple[Linearisation, Linearisation]:
    """The nominal machine and the baseline fit, with noise estimated at the baseline."""
    progress("the machine as given")
    with model.work.in_any_case():
        nominal = first(model, COARSE, seed)
    _require_answers(nominal)
    progress("the baseline")
    try:
        return _refitted(nominal, seed)
    except SearchEnded:
        return nominal, nominal


def _refitted(nominal: Linearisation, seed: int) -> tuple[Linearisation, Linearisation]:
    """The nominal machine and the baseline fit, by the noise at the baseline."""
    model, baseline = nominal.model, fitted(nominal, 5, restarts=1)
    corrected = model.with_sampling_correction(baseline.x, list(model.space.effects))
    parts = part_deviations(corrected, baseline.x)
    for _ in range(NOISE.noise_estimates):
        noise = estimated_noise(corrected, baseline.x, FINE, seed, parts)
        baseline = settled(fitted(with_noise(baseline, noise), 4))
    return with_noise(nominal, noise), baseline


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
