"""Screening: which effects may explain the residual at a point, by the reduction each promises.

Linear in an effect's amplitudes, which are tried at small sizes: guesses for the shortlist.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from hannes.core.effect import Effect
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.tuning import FIT, SEARCH
from hannes.plants.part_fault import part_faults

SMALL = (1.0,)  # steps of an amplitude


@dataclass(frozen=True)
class Guess:
    """Linear prediction for an effect: its reduction of chi-squared, and where it would lie.

    x: values of the effect's parameters at `places`
    signature: whitened derivatives by its amplitudes, (amplitudes, N)
    refitted: whether its reduction is one of a fit by now
    """

    effect: str
    delta_chi2: float
    places: np.ndarray
    x: np.ndarray
    signature: np.ndarray
    refitted: bool = False


def screened(
    point: Linearisation, effects: Sequence[str], sizes: Sequence[float] = SMALL
) -> list[Guess]:
    """The best guess for each effect, the largest reduction first."""
    trials = [
        (name, shape, steps)
        for name in effects
        for k, shape in enumerate(shapes(point.space.effects[name]))
        for steps in stepped(point, name, sizes if k == 0 else sizes[:1])
    ]
    guesses: dict[str, Guess] = {}
    if not trials:
        return []
    for (name, shape, steps), rows in zip(trials, secants(point, trials), strict=True):
        for twin, side in _twins(point.space.effects[name], shape):
            found = _guess(point, name, twin, side * rows, abs(steps[0]))
            if name not in guesses or found.delta_chi2 > guesses[name].delta_chi2:
                guesses[name] = found
    return sorted(guesses.values(), key=lambda each: -each.delta_chi2)


def screened_widely(
    point: Linearisation,
    effects: Sequence[str],
    sizes: Sequence[float] = SEARCH.screening_sizes,
    fault_sizes: Sequence[float] = SEARCH.fault_sizes,
) -> list[Guess]:
    """The same at ever larger sizes to the end of every range; faults of like parts at fewer.

    An effect that is large may have another signature than a small one.
    """
    faults = part_faults(point.space.effects, effects)
    laws = [name for name in effects if name not in faults]
    found = screened(point, laws, sizes) + screened(point, list(faults), fault_sizes)
    return sorted(found, key=lambda each: -each.delta_chi2)


def stepped(point: Linearisation, name: str, sizes: Sequence[float]) -> list[np.ndarray]:
    """Steps of an effect's amplitudes at each size that their ranges contain, (amplitudes,) each.

    An amplitude whose range lacks the first size is tried with the opposite sign.
    """
    space = point.space
    places = [space.place(each) for each in amplitude_names(space.effects[name])]
    low, high = space.low[places], space.high[places]
    sides = np.where((low <= sizes[0]) & (sizes[0] <= high), 1.0, -1.0)
    return [
        sides * size for size in sizes if np.all((low <= sides * size) & (sides * size <= high))
    ]


def shapes(effect: Effect) -> list[dict[str, float]]:
    """Values at which parameters without `off` are tried, by full name [SI]."""
    free = [each for each in effect.fitted if each.off is None]
    count = SEARCH.shapes if len(free) == 1 else 3
    tried = [
        np.unique([each.value, *(each.tried or _spread(*each.bounds, count - 1))]) for each in free
    ]
    names = [effect.full_name(each.name) for each in free]
    return [dict(zip(names, map(float, values), strict=True)) for values in product(*tried)]


def _twins(effect: Effect, shape: dict[str, float]) -> list[tuple[dict[str, float], float]]:
    """A shape, and those whose signature is its negative; with the sign of each."""
    found = [(shape, 1.0)]
    for each in effect.parameters:
        name = effect.full_name(each.name)
        if each.turns is not None and shape[name] + each.turns <= each.bounds[1]:
            found.append(({**shape, name: shape[name] + each.turns}, -1.0))
    return found


def _spread(low: float, high: float, count: int) -> np.ndarray:
    """Values inside bounds, evenly in their logarithm where that exists."""
    inner = np.linspace(0.0, 1.0, count + 2)[1:-1]
    return low * (high / low) ** inner if low > 0.0 else low + (high - low) * inner


def secants(
    point: Linearisation, trials: Sequence[tuple[str, dict[str, float], np.ndarray]]
) -> list[np.ndarray]:
    """Whitened change of all groups per step of each trial's amplitudes, shape (amplitudes, N)."""
    model, x = point.model, point.x
    rows, spans, steps = list[np.ndarray](), [], list[float]()
    for name, shape, sizes in trials:
        amplitudes = [model.space.place(n) for n in amplitude_names(model.space.effects[name])]
        pairs = zip(amplitudes, sizes.tolist(), strict=True)
        rows += [_at(model, x, shape, place, size) for place, size in pairs]
        steps += sizes.tolist()
        spans.append(len(amplitudes))
    stacked, per_step = np.array(rows), np.array(steps)[:, np.newaxis]
    changes = []
    for group in model.groups:
        made = _changes(model, group, x, stacked)
        changes.append(np.nan_to_num(made / per_step, posinf=0.0, neginf=0.0))
    whole = point.noise.together(changes)
    return np.split(whole, np.cumsum(spans)[:-1])


def _changes(model: Model, group: Group, x: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Changes at rows; one that strays from the steps of the run at x is a run of its own."""
    made = model.changes(group, x, rows, True)
    lost = ~np.isfinite(made).all(axis=1)
    if lost.any():
        apart = model.vectors(group, np.vstack([x, rows[lost]]), True)
        made[lost] = apart[1:] - apart[0]
    return made


def amplitude_names(effect: Effect) -> list[str]:
    """Full names of the parameters that have an `off`."""
    return [effect.full_name(each.name) for each in effect.amplitudes]


def _at(
    model: Model, x: np.ndarray, shape: dict[str, float], place: int, size: float
) -> np.ndarray:
    moved = _shaped(model, x, shape)
    moved[place] += size
    return moved


def _shaped(model: Model, x: np.ndarray, shape: dict[str, float]) -> np.ndarray:
    """A copy of x where an effect's shape has these values [SI]."""
    moved = x.copy()
    for name, value in shape.items():
        where = model.space.place(name)
        moved[where] = model.space.parameters[where].x(value)
    return moved


def _guess(
    point: Linearisation, name: str, shape: dict[str, float], rows: np.ndarray, size: float
) -> Guess:
    model = point.model
    delta_chi2, places, found = _solved(point, name, rows)
    ratio = float(np.abs(found).max() / size)
    if ratio > SEARCH.secant_range or (ratio < 1.0 / SEARCH.secant_range and size > SMALL[0]):
        delta_chi2 *= 0.5  # predicted by a secant of another size
    own = model.space.of(name)
    x = _shaped(model, np.zeros(model.space.size), shape)
    x[places] = found
    return Guess(name, delta_chi2, own, x[own], rows)


def _solved(
    point: Linearisation, name: str, rows: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Reduction of chi-squared along an effect's signature, the amplitudes' indices and sizes."""
    from scipy.optimize import lsq_linear

    space = point.space
    places = np.array([space.place(each) for each in amplitude_names(space.effects[name])])
    gradient, hessian = projected(point, rows)
    root = np.linalg.cholesky(hessian + FIT.effect_prior_weight * np.eye(len(places)))
    bounds = (space.low[places] - 1e-9, space.high[places] + 1e-9)
    found = lsq_linear(root.T, np.linalg.solve(root, gradient), bounds).x
    return float(2.0 * gradient @ found - found @ hessian @ found), places, found


def in_place_of(point: Linearisation, effect: str, guesses: Sequence[Guess]) -> dict[str, Guess]:
    """The guesses in the place of an effect, all else following, by name.

    Linear, and less the price of the parameters that each has more.
    """
    own, space = point.space.of(effect), point.space
    kept = ~np.isin(point.active, own)
    sizes = [space.place(each) for each in amplitude_names(space.effects[effect])]
    work = np.isin(point.active, sizes)
    there = replace(
        point,
        x=np.where(np.isin(np.arange(point.x.size), own), 0.0, point.x),
        active=point.active[kept],
        jacobian=point.jacobian[kept],
        residual=point.residual + point.x[point.active[work]] @ point.jacobian[work],
    )
    return {each.effect: _placed(there, each, len(own)) for each in guesses}


def _placed(point: Linearisation, guess: Guess, replaced: int) -> Guess:
    """A guess at another point, in the place of an effect with so many parameters."""
    delta_chi2, places, sizes = _solved(point, guess.effect, guess.signature)
    free = guess.effect in GENERIC_NAMES
    price = SEARCH.generic_price if free else SEARCH.parameter_price
    further = len(guess.places) - (1 if free else replaced)
    x = guess.x.copy()
    x[np.searchsorted(guess.places, places)] = sizes
    return replace(guess, delta_chi2=delta_chi2 - price * further, x=x)


def projected(point: Linearisation, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gradient and Hessian along further columns, all active parameters free."""
    moved = np.linalg.solve(point.hessian, point.jacobian @ rows.T)
    gradient = rows @ point.residual - moved.T @ point.gradient
    hessian = rows @ rows.T - (rows @ point.jacobian.T) @ moved
    return gradient, 0.5 * (hessian + hessian.T)


def cosine_similarity(point: Linearisation, one: np.ndarray, other: np.ndarray) -> float:
    """Largest cosine between two effects' signatures, beyond what other parameters can do."""
    size = len(one)
    _, whole = projected(point, np.vstack([one, other]))
    roots = []
    for part in (whole[:size, :size], whole[size:, size:]):
        roots.append(np.linalg.cholesky(part + FIT.effect_prior_weight * np.eye(len(part))))
    between = np.linalg.solve(roots[0], whole[:size, size:])
    cosines = np.linalg.svd(np.linalg.solve(roots[1], between.T), compute_uv=False)
    return float(min(1.0, cosines[0]))
