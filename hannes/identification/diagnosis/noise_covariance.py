"""The covariance of everything uncertain about the runs, as it is at one point."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hannes.identification.diagnosis.noise_model import Noise, of_repeats
from hannes.identification.diagnosis.part_deviations import PartDeviations
from hannes.identification.diagnosis.repeat_groups import Channels, Group
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.tuning import NOISE
from hannes.identification.whitening import Whitening
from hannes.plants.protocol import run_to_run_spread


@dataclass(frozen=True)
class NoiseAccuracy:
    """How accurately noise is to be known.

    nonlinearity: see Noise;  samples: simulations that average the controller's discretisation
    """

    nonlinearity: float
    samples: int


@dataclass(frozen=True)
class NoiseCovariance:
    """The covariance of all that is uncertain, which all fits of one diagnosis share.

    run_noise: of one run of each group
    discretisation: mean effect of the sampled controller on each group, shape (n,) each
    covariances: of the mean of each group's runs, everything uncertain in it, (n, n) each
    run_to_run: how the runs of each group differ, one standard deviation a row, (k, n)
    parts: what like parts are off for themselves, the same in all runs; None where nothing is
    simulated_noise: whether the noise is simulated, not estimated from a few repeats alone
    """

    model: Model
    run_noise: Noise
    discretisation: list[np.ndarray]
    covariances: list[np.ndarray]
    run_to_run: list[np.ndarray]
    simulated_noise: bool
    parts: PartDeviations | None = None

    @cached_property
    def shared(self) -> Whitening | None:
        """Whitens all groups together against what parts are off for themselves."""
        if self.parts is None:
            return None
        rows = self.parts.rows(self.model.groups)
        whole = np.concatenate([self.white(k, each) for k, each in enumerate(rows)], axis=-1)
        return Whitening.of(np.ones(whole.shape[1]), whole)

    @cached_property
    def expected(self) -> list[np.ndarray]:
        """What is expected of each group's runs beside a quick simulation, shape (n,) each."""
        if self.parts is None or not self.parts.at:
            return self.discretisation
        explained = self.parts.explained(self.model.groups)
        return [a - b for a, b in zip(self.discretisation, explained, strict=True)]

    @cached_property
    def roots(self) -> list[np.ndarray]:
        """Cholesky factors of the covariance of each group's mean, shape (n, n)."""
        return [np.linalg.cholesky(each) for each in self.covariances]

    def white(self, number: int, rows: np.ndarray) -> np.ndarray:
        """Rows (..., n) of a group, whitened by its covariance."""
        from scipy.linalg import solve_triangular

        return solve_triangular(self.roots[number], rows.T, lower=True, check_finite=False).T

    def together(self, rows: Sequence[np.ndarray]) -> np.ndarray:
        """Rows of all groups, whitened, shape (..., N)."""
        whole = np.concatenate([self.white(k, each) for k, each in enumerate(rows)], axis=-1)
        return self.shared(whole) if self.shared else whole


def estimated_noise(
    model: Model,
    x: np.ndarray,
    accuracy: NoiseAccuracy,
    seed: int,
    parts: PartDeviations | None = None,
) -> NoiseCovariance:
    """Noise, discretisation error and run-to-run variability at x; effects only where held.

    parts: what like parts of the machine are off for themselves, which joins it
    """
    discretisations = model.discretisation_errors(x, accuracy.samples, seed)
    channels = [model.simulated(group, x[np.newaxis], False)[0] or {} for group in model.groups]
    nonlinearities = [
        np.hypot(group.nonlinearity(each), group.onsets(each, NOISE.onset) if each else 0.0)
        for group, each in zip(model.groups, channels, strict=True)
    ]
    pairs = zip(model.groups, channels, strict=True)
    run_to_run = [run_to_run_rows(model, x, group, each) for group, each in pairs]
    deviations, roughnesses = (
        [each.deviations for each in discretisations],
        [each.roughness for each in discretisations],
    )
    times, simulated_noise = accuracy.nonlinearity, any(each.any() for each in deviations)
    if not simulated_noise:
        times = max(times, NOISE.repeats_nonlinearity)
        deviations, roughnesses = of_repeats(model.groups, nonlinearities, run_to_run, times)
    run_noise = Noise(model.groups, deviations, roughnesses, nonlinearities, run_to_run, times)
    covariances = [
        (run_noise.covariance(group) + np.diag((times * nonlinearity) ** 2) + rows.T @ rows)
        / group.count
        for group, nonlinearity, rows in zip(model.groups, nonlinearities, run_to_run, strict=True)
    ]
    for covariance, group, discretisation in zip(
        covariances, model.groups, discretisations, strict=True
    ):
        if discretisation.deviations.any():  # the mean of these simulations is uncertain too
            covariance += run_noise.moved(group) / len(discretisation.deviations)
    return NoiseCovariance(
        model,
        run_noise,
        [each.mean for each in discretisations],
        covariances,
        run_to_run,
        simulated_noise,
        parts,
    )


def run_to_run_rows(model: Model, x: np.ndarray, group: Group, channels: Channels) -> np.ndarray:
    """How a group's runs differ about x, one standard deviation a row, shape (k, n).

    With contacts a change is not the reverse of the opposite change. What both have in common is a
    row of its own.
    """
    space, sizes = model.space, _run_sizes(model, group)
    names = {space.parameters[k].name: k for k in space.uncertain if space.acting(group)[k]}
    steps = np.zeros((len(names), x.size))
    for step, (name, place) in zip(steps, names.items(), strict=True):
        step[place] = sizes.pop(name, 0.0) / space.parameters[place].scale
    steps = steps[steps.any(axis=1)]
    made = model.changes(group, x, np.vstack([x + steps, x - steps]), False)
    more, less = np.nan_to_num(made).reshape(2, len(steps), group.part.size)
    found = [*(0.5 * (more - less)), *(0.5 * (more + less))]
    found += [_own_step(model, group, name, size) for name, size in sizes.items() if size]
    later, earlier = (group.vector(channels, side * NOISE.start_shift) for side in (0.5, -0.5))
    found.append((later - earlier) * space.settings.start_time / NOISE.start_shift)
    return np.array(found)


def _own_step(model: Model, group: Group, name: str, size: float) -> np.ndarray:
    """Change by a parameter that is certain for the machine, but varies from run to run."""
    many, value = getattr(model.small, "many", None), group.nominal[name]
    if many is None or name not in model.small.parameters:
        return np.zeros(group.part.size)
    ends = many({name: np.array([value, value - size])}, group.recording, group.names, False)
    if any(each is None for each in ends):
        return np.zeros(group.part.size)
    return group.vector(ends[0]) - group.vector(ends[1])


def _run_sizes(model: Model, group: Group) -> dict[str, float]:
    """What varies from run to run in a group, one standard deviation [SI] by full name."""
    sizes = dict(run_to_run_spread(model.small))
    factor = model.space.settings.run_scatter / Settings.run_scatter
    others = {name for each in model.groups for name in each.own} - set(group.own)
    return {name: size * factor for name, size in sizes.items() if name not in others}
