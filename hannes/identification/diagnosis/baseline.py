"""The machine as given, and refitted without any effect: what everything else is compared with."""

from collections.abc import Sequence

from hannes.core.effect import Effect
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Care, Point, first, grounded, surveyed
from hannes.identification.diagnosis.multistart import Told
from hannes.identification.diagnosis.parameter_space import Space
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.run_to_run import in_keeping
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.plants.protocol import Plant

ROUGH, FINE = Care(10.0, 3), Care(1.0, 40)  # by the one a fit finds its way, by the other it ends
SURVEYS = 2  # of noise: where fingers touch, what runs differ in depends on where the base is


def based(
    plant: Plant,
    groups: Sequence[Group],
    settings: Settings,
    effects: Sequence[Effect],
    seed: int,
    told: Told,
) -> tuple[Point, Point]:
    """As given and refitted; once more where repeats show that runs differ further than told."""

    def model(settings: Settings) -> Model:
        return Model(plant, groups, Space(plant, groups, settings, effects), effects)

    given, base = _fitted(model(settings), seed, told)
    if (shown := in_keeping(base.ground, settings)) != settings:
        return _fitted(model(shown), seed, told)
    return given, base


def _fitted(model: Model, seed: int, told: Told) -> tuple[Point, Point]:
    """The machine as given, and refitted without any effect, with noise as it is there."""
    told("the machine as given")
    given = first(model, ROUGH, seed)
    told("the base")
    base = fitted(given, 5, anew=1)
    ticking = model.ticking(base.x, list(model.space.effects))
    for _ in range(SURVEYS):
        ground = surveyed(ticking, base.x, FINE, seed)
        base = settled(fitted(grounded(base, ground), 4))
    return grounded(given, ground), base
