"""Chi-squared linearised about one point of the parameter space."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.noise_covariance import (
    NoiseAccuracy,
    NoiseCovariance,
    estimated_noise,
)
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.part_deviations import PartDeviations
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.simulator import NOWHERE, Model
from hannes.identification.diagnosis.tuning import FIT, SEARCH


@dataclass(frozen=True)
class Linearisation:
    """A point x, shape (size,), of which the parameters in `active` may move.

    vectors: simulated bin means of each group
    derivatives: of these by x, shape (active, n) each
    residual: whitened measured minus simulated, (N,);  jacobian: whitened derivatives, (active, N)
    last_reduction: of chi-squared, in the last round of a fit that ends here
    """

    noise: NoiseCovariance
    x: np.ndarray
    active: np.ndarray
    vectors: list[np.ndarray] = field(repr=False)
    derivatives: list[np.ndarray] = field(repr=False)
    residual: np.ndarray = field(repr=False)
    jacobian: np.ndarray = field(repr=False)
    last_reduction: float = np.inf

    @property
    def model(self) -> Model:
        """What simulates the runs."""
        return self.noise.model

    @property
    def space(self) -> ParameterSpace:
        """All parameters that a fit may move."""
        return self.noise.model.space

    @cached_property
    def chi2(self) -> float:
        """Squared distance of recordings and of parameters, in standard deviations."""
        return float(self.residual @ self.residual + np.sum((self.space.prior * self.x) ** 2))

    @cached_property
    def prior(self) -> np.ndarray:
        """Roots of the prior weights of the active parameters."""
        return self.space.prior[self.active]

    @cached_property
    def hessian(self) -> np.ndarray:
        """Gauss-Newton Hessian of half of chi-squared by the active parameters."""
        return self.jacobian @ self.jacobian.T + np.diag(self.prior**2)

    @cached_property
    def gradient(self) -> np.ndarray:
        """Gradient of the log-likelihood, which is minus half of chi-squared."""
        return self.jacobian @ self.residual - self.prior**2 * self.x[self.active]

    @property
    def cheaply_derived(self) -> bool:
        """Whether a look at every effect's derivatives takes little work."""
        return self.model.round_of_derivatives() <= SEARCH.much_work

    @property
    def predicted_reduction(self) -> float:
        """By how much chi-squared would fall in a whole step, were it quadratic."""
        return float(self.gradient @ np.linalg.solve(self.hessian, self.gradient))

    def moved(self, x: np.ndarray, fresh: np.ndarray) -> "Linearisation | None":
        """The point at another x, with new derivatives along `fresh` and the others kept.

        None where the machine cannot be simulated there.
        """
        noise = self.noise
        vectors, made = differenced(noise.model, x, fresh, self._has_effects)
        if not all(np.isfinite(each).all() for each in vectors):
            return None
        places = np.searchsorted(self.active, fresh)
        derivatives = [each.copy() for each in self.derivatives]
        jacobian = self.jacobian.copy()
        for old, new in zip(derivatives, made, strict=True):
            old[places] = new
        if fresh.size:
            jacobian[places] = noise.together(made)
        return Linearisation(
            noise, x, self.active, vectors, derivatives, whitened_residual(noise, vectors), jacobian
        )

    def chi2_at(self, places: np.ndarray, following: bool = False) -> np.ndarray:
        """Chi-squared at each of the points x, shape (m, size); infinite where a run fails.

        A point is not simulated where its prior alone exceeds chi-squared here, or what a perfect
        fit would leave: no step leads there, and such a machine may take minutes. Where a machine
        takes much work anyway, nor is one that no chi-squared makes likely.
        following: after all active parameters have followed, as far as the linearisation predicts
        """
        found = np.full(len(places), np.inf)
        off = np.sum((self.space.prior * places) ** 2, axis=1)
        costly = self.model.round_of_derivatives() >= SEARCH.little_work
        most = min(self.chi2, FIT.farthest) if costly else self.chi2
        near = np.flatnonzero(off <= max(most, self.residual.size))
        if not near.size:
            return found
        made = self._vectors_at(places[near])
        for row, k in enumerate(near):
            vectors = [each[row] for each in made]
            if all(np.isfinite(each).all() for each in vectors):
                there = replace(self, x=places[k], residual=whitened_residual(self.noise, vectors))
                found[k] = there.chi2 - (there.predicted_reduction if following else 0.0)
        return found

    def _vectors_at(self, places: np.ndarray) -> list[np.ndarray]:
        """Vectors of each group at points, shape (m, n); many of them as changes from here."""
        model, effects = self.model, self._has_effects
        if len(places) < FIT.points_as_changes:
            return [model.vectors(group, places, effects) for group in model.groups]
        groups = zip(model.groups, self.vectors, strict=True)
        return [
            here + model.changes(group, self.x, places, effects, here) for group, here in groups
        ]

    @property
    def _has_effects(self) -> bool:
        return self.active.size > self.space.uncertain.size

    def corrected(self, before: "Linearisation") -> "Linearisation":
        """The point with its Jacobian updated by what the step from `before` did (Broyden)."""
        step = (self.x - before.x)[self.active]
        if (length := float(step @ step)) < 1e-8:
            return self
        wrong = (before.residual - self.residual) - step @ (0.5 * (self.jacobian + before.jacobian))
        return replace(self, jacobian=self.jacobian + np.outer(step, wrong) / length)

    def with_active(self, active: np.ndarray) -> "Linearisation":
        """The same point with other parameters active; new ones have zero derivatives at first."""
        noise, known = self.noise, np.isin(active, self.active)
        places = np.searchsorted(self.active, active[known])
        derivatives = [np.zeros((active.size, each.shape[1])) for each in self.derivatives]
        jacobian = np.zeros((active.size, self.jacobian.shape[1]))
        for new, old in zip(derivatives, self.derivatives, strict=True):
            new[known] = old[places]
        jacobian[known] = self.jacobian[places]
        return Linearisation(
            noise, self.x, active, self.vectors, derivatives, self.residual, jacobian
        )


def whitened_residual(noise: NoiseCovariance, vectors: Sequence[np.ndarray]) -> np.ndarray:
    """Whitened measured minus simulated of all groups, shape (N,)."""
    groups = zip(noise.model.groups, vectors, noise.expected, strict=True)
    return noise.together([group.mean - made - expected for group, made, expected in groups])


def differenced(
    model: Model, x: np.ndarray, along: np.ndarray, effects: bool
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Vectors of all groups at x, and their derivatives by some parameters, (parameters, n)."""
    vectors, derivatives = [], []
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
        derivatives.append(found)
    return vectors, derivatives


def _near(
    model: Model, group: Group, here: np.ndarray, x: np.ndarray, rows: np.ndarray, effects: bool
) -> np.ndarray:
    """Changes at rows near x; simulated alone where a run cannot follow the one at x.

    Where that fails too, by what less of the step does, or as much the other way.
    """
    changes = model.changes(group, x, rows, effects, here)
    for share in FIT.other_steps:
        lost = ~np.isfinite(changes).all(axis=1)
        if not lost.any():
            break
        made = model.vectors(group, x + share * (rows[lost] - x), effects)
        changes[lost] = (made - here) / share
    return changes


def _steps(model: Model, x: np.ndarray, along: np.ndarray) -> np.ndarray:
    """One row for each parameter: a step towards its nominal value, inside its bounds."""
    space, steps = model.space, np.zeros((along.size, x.size))
    for row, place in zip(steps, along, strict=True):
        size = FIT.effect_step if space.parameters[place].effect else FIT.machine_step
        row[place] = size if x[place] <= 0.0 else -size
        if not space.low[place] <= x[place] + row[place] <= space.high[place]:
            row[place] = -row[place]
    return steps


def first(model: Model, accuracy: NoiseAccuracy, seed: int) -> Linearisation:
    """The nominal point, without any effect."""
    return begun(model, np.zeros(model.space.size), model.space.uncertain, accuracy, seed)


def begun(
    model: Model,
    x: np.ndarray,
    active: np.ndarray,
    accuracy: NoiseAccuracy,
    seed: int,
    parts: PartDeviations | None = None,
) -> Linearisation:
    """The point at x with noise estimated there; ComputationFailed where it cannot be simulated.

    parts: what like parts are off for themselves
    """
    effects = active.size > model.space.uncertain.size
    vectors, derivatives = differenced(model, x, active, effects)
    if not all(np.isfinite(each).all() for each in vectors):
        raise ComputationFailed(NOWHERE)
    noise = estimated_noise(model, x, accuracy, seed, parts)
    return _assembled(noise, x, active, vectors, derivatives)


def with_noise(
    point: Linearisation,
    noise: NoiseCovariance,
    vectors: list[np.ndarray] | None = None,
    derivatives: list[np.ndarray] | None = None,
) -> Linearisation:
    """The same point with another noise covariance, and other vectors where its groups differ."""
    vectors, derivatives = vectors or point.vectors, derivatives or point.derivatives
    return _assembled(noise, point.x, point.active, vectors, derivatives)


def _assembled(
    noise: NoiseCovariance,
    x: np.ndarray,
    active: np.ndarray,
    vectors: list[np.ndarray],
    derivatives: list[np.ndarray],
) -> Linearisation:
    residual, jacobian = whitened_residual(noise, vectors), noise.together(derivatives)
    return Linearisation(noise, x, active, vectors, derivatives, residual, jacobian)
