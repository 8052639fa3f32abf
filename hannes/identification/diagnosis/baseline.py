"""The nominal machine and the baseline fit, against which every effect is compared."""

from collections.abc import Sequence

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation, first, with_noise
from hannes.identification.diagnosis.multistart import Progress
from hannes.identification.diagnosis.noise_covariance import NoiseAccuracy, estimated_noise
from hannes.identification.diagnosis.noise_model import recorded_roughness
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.run_to_run import settings_from_repeats
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.tuning import NOISE
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
) -> tuple[Linearisation, Linearisation]:
    """The nominal and the refitted machine.

    Fitted once more where repeats show more run-to-run variability than the settings assume.
    """

    def model(settings: Settings) -> Model:
        return Model(plant, groups, ParameterSpace(plant, groups, settings, effects), effects)

    nominal, baseline = _fitted(model(settings), seed, progress)
    if (shown := settings_from_repeats(baseline.noise, settings)) != settings:
        return _fitted(model(shown), seed, progress)
    return nominal, baseline


def _fitted(model: Model, seed: int, progress: Progress) -> tuple[Linearisation, Linearisation]:
    """The nominal machine and the baseline fit, with noise estimated at the baseline."""
    progress("the machine as given")
    nominal = first(model, COARSE, seed)
    _require_answers(nominal)
    progress("the baseline")
    baseline = fitted(nominal, 5, restarts=1)
    corrected = model.with_sampling_correction(baseline.x, list(model.space.effects))
    for _ in range(NOISE.noise_estimates):
        noise = estimated_noise(corrected, baseline.x, FINE, seed)
        baseline = settled(fitted(with_noise(baseline, noise), 4))
    return with_noise(nominal, noise), baseline


def _require_answers(nominal: Linearisation) -> None:
    """Raise BadInput for a channel that stays zero whatever the machine's values are nearby.

    No fit leads from there, and what is recorded would all look like something missing.
    """
    groups = zip(nominal.model.groups, nominal.vectors, nominal.derivatives, strict=True)
    for group, vector, derivatives in groups:
        rough = recorded_roughness(group)
        for name in group.names:
            place = group.of(name)
            silent = not vector[place].any() and not derivatives[:, place].any()
            if silent and np.ptp(group.mean[place]) > NOISE.alive * rough[name]:
                raise BadInput(
                    f"{group.entries[0].name}: the simulated {name} is zero throughout, whatever "
                    "the machine's values are nearby, and the recorded one is not: set base, or "
                    "the experiment's object, to what is nearer"
                )
