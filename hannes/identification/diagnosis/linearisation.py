"""The misfit made linear about one place of the space."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.noise_model import Noise, of_repeats
from hannes.identification.diagnosis.repeat_groups import Channels, Group
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import NOWHERE, SHIFT, Model
from hannes.plants.protocol import run_to_run_spread

STEP = 0.5  # standard deviations of what is uncertain, to difference by
REPEATED = 2.0  # times a stray inside a bin, at least, where only repeats tell how noisy runs are
MANY = 4  # places: so many are simulated as changes, which take a wider tolerance
FINE = 0.3  # steps of an effect's parameter, to difference by


@dataclass(frozen=True)
class Care:
    """How well noise is to be known: see Noise for `jerk`; simulations that average the grain."""

    jerk: float
    samples: int


@dataclass(frozen=True)
class Ground:
    """What all points of one diagnosis share.

    noise: of a run of each group; grain: what firmware adds, shape (n,) each
    covariances: of the mean of each group's runs, all that is not known of them in it, (n, n) each
    restless: how each group's runs differ from each other, one standard deviation a row, (k, n)
    told: how noisy runs are follows from the machine simulated, not from a few repeats alone
    """

    model: Model
    noise: Noise
    grain: list[np.ndarray]
    covariances: list[np.ndarray]
    restless: list[np.ndarray]
    told: bool

    @cached_property
    def roots(self) -> list[np.ndarray]:
        """Cholesky factors of the covariance of each group's mean, shape (n, n)."""
        return [np.linalg.cholesky(each) for each in self.covariances]

    def white(self, number: int, rows: np.ndarray) -> np.ndarray:
        """Rows (..., n) of a group in standard deviations, what hangs together counted once."""
        from scipy.linalg import solve_triangular

        return solve_triangular(self.roots[number], rows.T, lower=True, check_finite=False).T

    def together(self, rows: Sequence[np.ndarray]) -> np.ndarray:
        """Rows of all groups, whitened, shape (..., N)."""
        return np.concatenate([self.white(k, each) for k, each in enumerate(rows)], axis=-1)


@dataclass(frozen=True)
class Point:
    """A place x, shape (size,), of which the directions in `active` may move.

    vectors: simulated bin means of each group; slopes: their change by x, shape (active, n) each
    miss: whitened measured minus simulated, (N,); columns: whitened slopes, (active, N)
    """

    ground: Ground
    x: np.ndarray
    active: np.ndarray
    vectors: list[np.ndarray] = field(repr=False)
    slopes: list[np.ndarray] = field(repr=False)
    miss: np.ndarray = field(repr=False)
    columns: np.ndarray = field(repr=False)

    @cached_property
    def misfit(self) -> float:
        """Squared distance of the recordings and of what is uncertain, in standard deviations."""
        return float(self.miss @ self.miss + np.sum((self.ground.model.space.prior * self.x) ** 2))

    @property
    def prior(self) -> np.ndarray:
        """Roots of the weights of the active directions."""
        return self.ground.model.space.prior[self.active]

    @cached_property
    def curvature(self) -> np.ndarray:
        """Half the second derivative of the misfit by the active directions."""
        return self.columns @ self.columns.T + np.diag(self.prior**2)

    @cached_property
    def pull(self) -> np.ndarray:
        """Minus half the gradient of the misfit."""
        return self.columns @ self.miss - self.prior**2 * self.x[self.active]

    @property
    def hoped(self) -> float:
        """By how much the misfit would fall in a whole step, were it quadratic."""
        return float(self.pull @ np.linalg.solve(self.curvature, self.pull))

    def moved(self, x: np.ndarray, fresh: np.ndarray) -> "Point | None":
        """The point at another x, slopes along `fresh` anew and the others as they were.

        None where the machine cannot be simulated there.
        """
        ground = self.ground
        vectors, made = differenced(ground.model, x, fresh, self._has_effects)
        if not all(np.isfinite(each).all() for each in vectors):
            return None
        places = np.searchsorted(self.active, fresh)
        slopes = [each.copy() for each in self.slopes]
        columns = self.columns.copy()
        for old, new in zip(slopes, made, strict=True):
            old[places] = new
        if fresh.size:
            columns[places] = ground.together(made)
        return Point(ground, x, self.active, vectors, slopes, missed(ground, vectors), columns)

    def misfits(self, places: np.ndarray, following: bool = False) -> np.ndarray:
        """Misfit at each of the places x, shape (m, size); infinite where nothing can be run.

        Nor is anything run where the machine's values alone are further off than all is here, or
        would be were the recordings explained: no step leads there, and a machine like that may
        take minutes.
        following: after all active directions have followed, as far as slopes from here tell
        """
        found = np.full(len(places), np.inf)
        off = np.sum((self.ground.model.space.prior * places) ** 2, axis=1)
        near = np.flatnonzero(off <= max(self.misfit, self.miss.size))
        if not near.size:
            return found
        made = self._vectors_at(places[near])
        for row, k in enumerate(near):
            vectors = [each[row] for each in made]
            if all(np.isfinite(each).all() for each in vectors):
                there = replace(self, x=places[k], miss=missed(self.ground, vectors))
                found[k] = there.misfit - (there.hoped if following else 0.0)
        return found

    def _vectors_at(self, places: np.ndarray) -> list[np.ndarray]:
        """Of each group at places, shape (m, n): of many by what they change from here, quicker."""
        model, effects = self.ground.model, self._has_effects
        if len(places) < MANY:
            return [model.vectors(group, places, effects) for group in model.groups]
        groups = zip(model.groups, self.vectors, strict=True)
        return [
            here + model.changes(group, self.x, places, effects, here) for group, here in groups
        ]

    @property
    def _has_effects(self) -> bool:
        return self.active.size > self.ground.model.space.uncertain.size

    def corrected(self, before: "Point") -> "Point":
        """The point with its slopes mended by what the step from `before` really did (Broyden)."""
        step = (self.x - before.x)[self.active]
        if (length := float(step @ step)) < 1e-8:
            return self
        wrong = (before.miss - self.miss) - step @ (0.5 * (self.columns + before.columns))
        return replace(self, columns=self.columns + np.outer(step, wrong) / length)

    def with_active(self, active: np.ndarray) -> "Point":
        """The same place with other directions active: slopes along new ones are zero until had."""
        ground, known = self.ground, np.isin(active, self.active)
        places = np.searchsorted(self.active, active[known])
        slopes = [np.zeros((active.size, each.shape[1])) for each in self.slopes]
        columns = np.zeros((active.size, self.columns.shape[1]))
        for new, old in zip(slopes, self.slopes, strict=True):
            new[known] = old[places]
        columns[known] = self.columns[places]
        return Point(ground, self.x, active, self.vectors, slopes, self.miss, columns)


def missed(ground: Ground, vectors: Sequence[np.ndarray]) -> np.ndarray:
    """Whitened measured minus simulated of all groups, shape (N,)."""
    groups = zip(ground.model.groups, vectors, ground.grain, strict=True)
    return ground.together([group.mean - made - grain for group, made, grain in groups])


def differenced(
    model: Model, x: np.ndarray, along: np.ndarray, effects: bool
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Vectors of all groups at x, and their change along some directions, (directions, n)."""
    vectors, slopes = [], []
    for group in model.groups:
        acting = model.space.acting(group)[along]
        steps = _steps(model, x, along[acting])
        found = np.zeros((along.size, group.part.size))
        here = model.vectors(group, x[np.newaxis], effects)[0]
        if len(steps):
            sizes = steps[np.arange(len(steps)), along[acting]]
            changes = _near(model, group, here, x, x + steps, effects) / sizes[:, np.newaxis]
            found[acting] = np.nan_to_num(changes, posinf=0.0, neginf=0.0)
        vectors.append(here)
        slopes.append(found)
    return vectors, slopes


def _near(
    model: Model, group: Group, here: np.ndarray, x: np.ndarray, rows: np.ndarray, effects: bool
) -> np.ndarray:
    """What rows near x change by; by runs of their own where none can follow that at x."""
    changes = model.changes(group, x, rows, effects, here)
    lost = ~np.isfinite(changes).all(axis=1)
    if lost.any():
        changes[lost] = model.vectors(group, rows[lost], effects) - here
    return changes


def _steps(model: Model, x: np.ndarray, along: np.ndarray) -> np.ndarray:
    """One row for each direction: towards its given value, and never out of bounds."""
    space, steps = model.space, np.zeros((along.size, x.size))
    for row, place in zip(steps, along, strict=True):
        size = FINE if space.directions[place].effect else STEP
        row[place] = size if x[place] <= 0.0 else -size
        if not space.low[place] <= x[place] + row[place] <= space.high[place]:
            row[place] = -row[place]
    return steps


def first(model: Model, care: Care, seed: int) -> Point:
    """The point where everything is as given and no effect is there."""
    return begun(model, np.zeros(model.space.size), model.space.uncertain, care, seed)


def begun(model: Model, x: np.ndarray, active: np.ndarray, care: Care, seed: int) -> Point:
    """The point at x, and the ground as it is there; ComputationFailed where none can be run."""
    effects = active.size > model.space.uncertain.size
    vectors, slopes = differenced(model, x, active, effects)
    if not all(np.isfinite(each).all() for each in vectors):
        raise ComputationFailed(NOWHERE)
    return _on(surveyed(model, x, care, seed), x, active, vectors, slopes)


def surveyed(model: Model, x: np.ndarray, care: Care, seed: int) -> Ground:
    """Noise, grain, and what runs differ in, as they are at x, of effects only those held."""
    grains = model.grain(x, care.samples, seed)
    channels = [model.simulated(group, x[np.newaxis], False)[0] or {} for group in model.groups]
    jerks = [group.jerk(each) for group, each in zip(model.groups, channels, strict=True)]
    pairs = zip(model.groups, channels, strict=True)
    restless = [run_to_run(model, x, group, each) for group, each in pairs]
    strays, roughs = [each.strays for each in grains], [each.rough for each in grains]
    times, told = care.jerk, any(each.any() for each in strays)
    if not told:
        times = max(times, REPEATED)
        strays, roughs = of_repeats(model.groups, jerks, restless, times)
    noise = Noise(model.groups, strays, roughs, jerks, restless, times)
    covariances = [
        (noise.covariance(group) + np.diag((times * jerk) ** 2) + rows.T @ rows) / group.count
        for group, jerk, rows in zip(model.groups, jerks, restless, strict=True)
    ]
    for covariance, group, grain in zip(covariances, model.groups, grains, strict=True):
        if grain.strays.any():  # the mean of so many simulations is not sure either
            covariance += noise.moved(group) / len(grain.strays)
    return Ground(model, noise, [each.mean for each in grains], covariances, restless, told)


def grounded(
    point: Point,
    ground: Ground,
    vectors: list[np.ndarray] | None = None,
    slopes: list[np.ndarray] | None = None,
) -> Point:
    """The same place on another ground, with vectors and slopes of its groups where they differ."""
    vectors, slopes = vectors or point.vectors, slopes or point.slopes
    return _on(ground, point.x, point.active, vectors, slopes)


def _on(
    ground: Ground,
    x: np.ndarray,
    active: np.ndarray,
    vectors: list[np.ndarray],
    slopes: list[np.ndarray],
) -> Point:
    miss, columns = missed(ground, vectors), ground.together(slopes)
    return Point(ground, x, active, vectors, slopes, miss, columns)


def run_to_run(model: Model, x: np.ndarray, group: Group, channels: Channels) -> np.ndarray:
    """How a group's runs differ about x, one standard deviation a row, shape (k, n).

    Where fingers touch, a change does not do one way what it does the other, reversed: what both
    ways have in common is a row of its own.
    """
    space, sizes = model.space, _run_sizes(model, group)
    names = {space.directions[k].name: k for k in space.uncertain if space.acting(group)[k]}
    steps = np.zeros((len(names), x.size))
    for step, (name, place) in zip(steps, names.items(), strict=True):
        step[place] = sizes.pop(name, 0.0) / space.directions[place].scale
    steps = steps[steps.any(axis=1)]
    made = model.changes(group, x, np.vstack([x + steps, x - steps]), False)
    more, less = np.nan_to_num(made).reshape(2, len(steps), group.part.size)
    found = [*(0.5 * (more - less)), *(0.5 * (more + less))]
    found += [_own_step(model, group, name, size) for name, size in sizes.items() if size]
    late, early = (group.vector(channels, side * SHIFT) for side in (0.5, -0.5))
    found.append((late - early) * space.settings.start_time / SHIFT)
    return np.array(found)


def _own_step(model: Model, group: Group, name: str, size: float) -> np.ndarray:
    """What a parameter that is certain for the machine, but not from run to run, does."""
    many, value = getattr(model.small, "many", None), group.nominal[name]
    if many is None or name not in model.small.parameters:
        return np.zeros(group.part.size)
    ends = many({name: np.array([value, value - size])}, group.recording, group.names, False)
    if any(each is None for each in ends):
        return np.zeros(group.part.size)
    return group.vector(ends[0]) - group.vector(ends[1])


def _run_sizes(model: Model, group: Group) -> dict[str, float]:
    """What changes from run to run in a group, one standard deviation [SI] by full name."""
    sizes = dict(run_to_run_spread(model.small))
    factor = model.space.settings.run_scatter / Settings.run_scatter
    others = {name for each in model.groups for name in each.own} - set(group.own)
    return {name: size * factor for name, size in sizes.items() if name not in others}
