"""Starts with several effects together: those that enter first along a path of the lasso.

Where several large effects are missing, the best single one may be none of them. So all effects are
fitted together, linearly and under a penalty on the sum of their sizes (Tibshirani 1996), the
machine's values following. As the penalty falls, effects enter one by one.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import (
    Progress,
    started_at,
    with_correction_at_size,
)
from hannes.identification.diagnosis.score_test import Guess, amplitude_names, projected
from hannes.identification.diagnosis.tuning import SEARCH

Start = tuple[tuple[str, ...], Linearisation]


def started_together(
    points: Sequence[tuple[Linearisation, Sequence[Guess]]],
    progress: Progress,
    counts: range = range(2, SEARCH.most_effects + 1),
) -> Iterator[Start]:
    """The effects that enter first at each point, and their fit; the likeliest sets first.

    points: each with guesses for the effects that it does not have
    counts: how many enter together
    """
    found = []
    for point, guesses in points:
        entered = entering(point, guesses)
        for count in (each for each in counts if each <= len(entered)):
            found += _placed(point, entered[:count])
    found.sort(key=lambda each: each[0])
    met = set[frozenset[str]]()
    for _, names, start, x in found:
        if len(met) == SEARCH.joint_starts:
            return
        if frozenset(names) not in met:
            met.add(frozenset(names))
            progress(f"{' and '.join(names)}, together".replace("_", " "))
            places = start.space.of(*names)
            begun = started_at(start, places, x[places])
            if begun is not None:
                yield names, _fitted(begun, names)


def _fitted(point: Linearisation, names: Sequence[str]) -> Linearisation:
    """The fit from a start, with the sampled-controller correction at the sizes found."""
    point = fitted(point, SEARCH.further_steps, restarts=1)
    for name in names:
        point = with_correction_at_size(point, name)
    return settled(point)


def entering(point: Linearisation, guesses: Sequence[Guess]) -> list[Guess]:
    """The guesses in the order in which they enter as the penalty falls, a few of them."""
    if not guesses:
        return []
    gradient, hessian = projected(point, np.vstack([each.signature for each in guesses]))
    low, high, owner = _bounds(point, guesses)
    order: list[int] = []
    for x in lasso_path(gradient, hessian, low, high):
        for k in owner[np.flatnonzero(x)].tolist():
            order += [] if k in order else [k]
        if len(order) >= SEARCH.most_effects:
            break
    return [guesses[k] for k in order[: SEARCH.most_effects]]


def lasso_path(
    gradient: np.ndarray, hessian: np.ndarray, low: np.ndarray, high: np.ndarray
) -> Iterator[np.ndarray]:
    """Minima of x'Hx/2 - g'x + penalty sum(s |x|) within bounds as the penalty falls, (m,) each.

    s is the root of the diagonal of H, so that units do not matter. By coordinate descent
    (Friedman, Hastie & Tibshirani 2010).
    """
    curvature = np.maximum(np.diag(hessian), 1e-12)
    scale, x = np.sqrt(curvature), np.zeros(gradient.size)
    for share in np.geomspace(1.0, SEARCH.least_penalty, SEARCH.penalties):
        penalty = share * float(np.max(np.abs(gradient) / scale)) * scale
        for _ in range(SEARCH.sweeps):
            before = x.copy()
            for k in range(x.size):
                pull = gradient[k] - hessian[k] @ x + curvature[k] * x[k]
                least = np.sign(pull) * max(abs(pull) - penalty[k], 0.0) / curvature[k]
                x[k] = min(max(least, low[k]), high[k])
            if np.abs(scale * (x - before)).max() < 1e-3 * penalty.max() / scale.max():
                break
        yield x.copy()


def _bounds(
    point: Linearisation, guesses: Sequence[Guess]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lowest and highest size of each amplitude, and the number of the guess that it is of."""
    space = point.space
    names = [amplitude_names(space.effects[each.effect]) for each in guesses]
    places = [space.place(name) for own in names for name in own]
    owner = np.repeat(np.arange(len(guesses)), [len(own) for own in names])
    return space.low[places], space.high[places], owner


def _placed(
    point: Linearisation, guesses: Sequence[Guess]
) -> list[tuple[float, tuple[str, ...], Linearisation, np.ndarray]]:
    """These effects at shares of their joint guess: chi-squared all else following, and where."""
    from scipy.optimize import lsq_linear

    space, names = point.space, tuple(each.effect for each in guesses)
    gradient, hessian = projected(point, np.vstack([each.signature for each in guesses]))
    root = np.linalg.cholesky(hessian + 1e-6 * np.trace(hessian) * np.eye(len(hessian)))
    low, high, _ = _bounds(point, guesses)
    sizes = lsq_linear(root.T, np.linalg.solve(root, gradient), (low - 1e-9, high + 1e-9)).x
    amplitudes = [space.place(n) for name in names for n in amplitude_names(space.effects[name])]
    rows = np.repeat(point.x[np.newaxis], len(SEARCH.guess_shares), axis=0)
    for each in guesses:
        rows[:, each.places] = each.x
    rows[:, amplitudes] = np.outer(SEARCH.guess_shares, sizes)
    rows = np.clip(rows, space.low, space.high)
    wider = point.with_active(np.union1d(point.active, space.of(*names)))
    left = wider.chi2_at(rows, following=True)
    best = int(np.argmin(left))
    return [(float(left[best]), names, point, rows[best])] if np.isfinite(left[best]) else []
