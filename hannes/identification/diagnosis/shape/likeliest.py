"""Which generic disturbances are likely: all by a linear fit, the best by Gauss-Newton.

They have a model of their own, so that no other run carries them. Fits start at the refitted
baseline, and at the machine as given, which the missing effect does not bias. All take some steps,
the better half some more, and so on.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.core.description import Description
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation, with_noise
from hannes.identification.diagnosis.multistart import negligible, started_at_guess
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.score_test import Guess, screened
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.trials import SearchResult
from hannes.identification.diagnosis.tuning import SEARCH, SHAPE
from hannes.identification.diagnosis.work_bound import SearchEnded, Work
from hannes.plants.protocol import Plant
from hannes.simulation.catalogue import descriptions

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Described:
    """A generic disturbance fitted with everything uncertain.

    base: the refitted baseline in the model of all generic disturbances
    reduction: of chi-squared, less the price of its numbers
    """

    description: Description
    base: Linearisation
    nominal: Linearisation
    point: Linearisation
    reduction: float


def likeliest(found: SearchResult, progress: Progress) -> list[Described]:
    """The generic disturbances that lower chi-squared enough, the one that lowers it most first."""
    model = found.baseline.model
    known = {n: e for n, e in applicable(model.small).items() if _history_known(e, model.groups)}
    progress("generic disturbances")
    model = _model(found, list(known.values()))
    nominal, base = (_carried(each, model) for each in (found.nominal, found.baseline))
    made: list[Described] = []
    try:
        for guess in _promising(nominal, base, list(known)):
            progress(guess.effect.replace("_", " "))
            for point in _starts(nominal, base, guess):
                reduction = _reduction(base, point, guess)
                made.append(Described(known[guess.effect], base, nominal, point, reduction))
        for each in _raced(made, progress):
            made.append(each)
        for each in _best_of_each(made):
            progress(f"{each.description.effect.name.replace('_', ' ')}, once more")
            made.append(_further(each, settled(each.point, _little(each))))
    except SearchEnded:
        pass
    enough = SHAPE.least * found.variance_factor
    return [each for each in _best_of_each(made) if each.reduction > enough]


def _best_of_each(made: Sequence[Described]) -> list[Described]:
    """The best fit of each generic disturbance, the largest reduction first."""
    best: dict[str, Described] = {}
    for each in sorted(made, key=lambda each: -each.reduction):
        best.setdefault(each.description.effect.name, each)
    return list(best.values())


def _raced(starts: Sequence[Described], progress: Progress) -> Iterator[Described]:
    """Fits after some steps of all, some more of the better half, until one is left.

    A linear fit about a machine far from the true one says little of what the whole fit reaches;
    a few steps say more. So the likeliest is far where the bound of work ends that.
    """
    racing = list(starts)
    while racing:
        progress(f"the best {len(racing)} fits of them")
        fits = []
        for each in racing:
            fits.append(_further(each, fitted(each.point, SHAPE.steps)))
            yield fits[-1]
        racing = sorted(fits, key=lambda each: -each.reduction)[: len(fits) // 2]


def _further(before: Described, point: Linearisation) -> Described:
    """The same disturbance at a later point of its fit."""
    reduction = before.reduction + before.point.chi2 - point.chi2
    return replace(before, point=point, reduction=reduction)


def _little(fit: Described) -> float:
    """Reduction of chi-squared that is negligible beside what it lowers."""
    return negligible(fit.base.chi2 - fit.point.chi2)


def applicable(plant: Plant) -> dict[str, Description]:
    """The generic disturbances that a plant can carry and lacks, its own among them, by name."""
    every = descriptions() | dict(getattr(plant, "generic", {}))
    present = {each.name for each in plant.effects}
    return {
        name: each
        for name, each in every.items()
        if name not in present and not plant.accepts(each.effect)
    }


def _history_known(description: Description, groups: Sequence[Group]) -> bool:
    """Whether recordings say what earlier runs did, as far as a disturbance grows with it."""
    wanted = [each.earlier for each in description.effect.parameters if each.earlier]
    return all(np.isfinite(group.earlier[name]).all() for group in groups for name in wanted)


def _model(found: SearchResult, known: Sequence[Description]) -> Model:
    """The same runs with every generic disturbance in the machine, and a bound of its own."""
    whole, effects = found.baseline.model, [each.effect for each in known]
    plant = whole.with_parts_at({}).small
    space = ParameterSpace(plant, whole.groups, whole.space.settings, effects)
    work = Work(bounded=True)
    work.limit = SHAPE.most_simulated
    made = Model(plant, whole.groups, space, effects, work, whole.bandwidth)
    return made.with_parts_at(whole.parts_at)


def _carried(point: Linearisation, model: Model) -> Linearisation:
    """A point without effects in another model of the same machine; nothing is simulated."""
    x = np.zeros(model.space.size)
    x[model.space.uncertain] = point.x[point.space.uncertain]
    return replace(point, noise=replace(point.noise, model=model), x=x)


def _promising(nominal: Linearisation, base: Linearisation, names: Sequence[str]) -> list[Guess]:
    """The guesses to be fitted, the best first; by the less biased of both machines."""
    biased = base.chi2 > SEARCH.biased_baseline * base.residual.size
    lost = nominal.chi2 - base.chi2
    rows = [*screened(base, names)]
    rows += [
        replace(each, delta_chi2=each.delta_chi2 - lost)
        for each in (screened(nominal, names) if biased else [])
    ]
    best: dict[str, Guess] = {}
    for guess in sorted(rows, key=_less_price, reverse=True):
        best.setdefault(guess.effect, guess)
    return [each for each in best.values() if _less_price(each) > 0.0][: SHAPE.fitted]


def _less_price(guess: Guess) -> float:
    return guess.delta_chi2 - SEARCH.generic_price * (len(guess.places) - 1)


def _reduction(base: Linearisation, point: Linearisation, guess: Guess) -> float:
    return base.chi2 - point.chi2 - SEARCH.generic_price * (len(guess.places) - 1)


def _starts(nominal: Linearisation, base: Linearisation, guess: Guess) -> list[Linearisation]:
    """The baseline, and the machine as given, with the disturbance as it was guessed."""
    starts = (started_at_guess(at, guess) for at in (base, with_noise(nominal, base.noise)))
    return [each for each in starts if each is not None]
