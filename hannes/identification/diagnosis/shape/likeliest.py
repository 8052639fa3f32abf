"""Which generic disturbance is likeliest: all by a linear fit, the best by Gauss-Newton.

They have a model of their own, so that no other run carries them. Fits start at the refitted
baseline, and at the machine as given, which the missing effect does not bias.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.core.description import Description
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation, with_noise
from hannes.identification.diagnosis.multistart import negligible, started_at, started_at_guess
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.score_test import Guess, screened
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.trials import SearchResult
from hannes.identification.diagnosis.tuning import SEARCH, SHAPE
from hannes.identification.diagnosis.work_bound import SearchEnded, Work
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


def likeliest(found: SearchResult, progress: Progress) -> Described | None:
    """The generic disturbance that lowers chi-squared most; None where none lowers it enough."""
    plant = found.baseline.model.small
    every = descriptions() | dict(getattr(plant, "generic", {}))
    known = {n: d for n, d in every.items() if not plant.accepts(d.effect)}
    if not known:
        return None
    progress("generic disturbances")
    model = _model(found, list(known.values()))
    nominal, base = (_carried(each, model) for each in (found.nominal, found.baseline))
    best = None
    try:
        for guess in _promising(nominal, base, list(known)):
            progress(guess.effect.replace("_", " "))
            for point in _fits(nominal, base, guess):
                made = Described(
                    known[guess.effect], base, nominal, point, _reduction(base, point, guess)
                )
                best = made if best is None or made.reduction > best.reduction else best
    except SearchEnded:
        pass
    return best if best and best.reduction > SHAPE.least * found.variance_factor else None


def _model(found: SearchResult, known: Sequence[Description]) -> Model:
    """The same runs with every generic disturbance in the machine, and a bound of its own."""
    whole, effects = found.baseline.model, [each.effect for each in known]
    space = ParameterSpace(whole.small, whole.groups, whole.space.settings, effects)
    work = Work(bounded=True)
    work.limit = SHAPE.most_simulated
    return Model(whole.small, whole.groups, space, effects, work)


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


def _fits(nominal: Linearisation, base: Linearisation, guess: Guess) -> list[Linearisation]:
    """Converged fits from the baseline, and from the machine as given at what was found there."""
    found = []
    for start in (base, with_noise(nominal, base.noise)):
        begun = started_at_guess(start, guess)
        if begun is not None:
            point = fitted(begun, FIRST)
            found.append(settled(point, negligible(base.chi2 - point.chi2)))
    if found and guess.places.size:
        values = min(found, key=lambda each: each.chi2).x[guess.places]
        again = started_at(base, guess.places, values)
        if again is not None:
            found.append(settled(fitted(again, FIRST), negligible(base.chi2 - again.chi2)))
    return found


FIRST = 5  # steps before derivatives are renewed
