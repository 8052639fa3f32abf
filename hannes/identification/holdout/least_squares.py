"""Fits a plant's parameters to recording segments: least squares, nominal values as prior.

Difference steps scale with each parameter's uncertainty, not with its value. They are coarse
first: a simulation with adaptive steps is smooth only down to its tolerance, and ripples must not
stop the search. They are fine later: contacts come and go within a coarse step.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hannes.campaigns.segments import Segment
from hannes.core.errors import ComputationFailed
from hannes.identification.holdout.tuning import HOLDOUT
from hannes.plants.protocol import Plant, free_amplitudes, robust

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Fitted:
    """A fit: values by name, their covariance, and what it was made of.

    `columns` is the Jacobian of the weighted residual, shape (samples, names), without priors;
    `scales` turns scaled parameters into SI.
    """

    plant: Plant
    names: tuple[str, ...]
    values: dict[str, float]
    scales: np.ndarray
    covariance: np.ndarray
    columns: np.ndarray
    prior: np.ndarray

    def deviation(self, name: str) -> float:
        """Standard deviation of a fitted parameter [its unit]."""
        place = self.names.index(name)
        return float(np.sqrt(self.covariance[place, place]))


class WeightedResidual:
    """Weighted difference between simulation and segments of recordings."""

    def __init__(
        self, plant: Plant, segments: Sequence[Segment], noise_floors: Mapping[str, float]
    ) -> None:
        self.plant, self.segments, self.noise_floors = plant, segments, noise_floors

    def raw(self, plant: Plant, values: Mapping[str, float]) -> list[dict[str, np.ndarray]]:
        """Simulated minus recorded of each segment and channel, over its counted samples."""
        runs: dict[bytes, dict[str, np.ndarray]] = {}
        found = []
        for segment in self.segments:
            key = self.plant.same_run(segment.recording)
            if key not in runs:
                with np.errstate(over="ignore", invalid="ignore"):  # a run that runs away says so
                    runs[key] = plant.simulate(values, segment.recording)
            found.append(self._difference(segment, runs[key]))
        return found

    def _difference(self, segment: Segment, run: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {
            name: (run[name] - segment.recording[name])[segment.mask]
            for name in self.noise_floors
            if name in segment.recording
        }

    def of(self, plant: Plant, values: Mapping[str, float]) -> np.ndarray:
        """`weighted` at some values; infinite where no run succeeds: a search steps back there."""
        try:
            return self.weighted(self.raw(plant, values))
        except ComputationFailed:
            return np.full(self.clusters().size, np.inf)

    def weighted(self, raw: Sequence[Mapping[str, np.ndarray]]) -> np.ndarray:
        """One vector in units of the noise floor, counting correlated samples once."""
        parts = []
        for segment, channels in zip(self.segments, raw, strict=True):
            interval = float(np.median(np.diff(segment.recording.time)))
            together = max(1.0, self.plant.block / HOLDOUT.moments_per_block / interval)
            parts += [
                softened(v, robust(self.plant, n)) / (self.noise_floors[n] * np.sqrt(together))
                for n, v in channels.items()
            ]
        return np.concatenate(parts)

    def clusters(self) -> np.ndarray:
        """Block number of every element of `weighted`; a block of all repeats is one cluster."""
        numbers: dict[tuple[bytes, int], int] = {}
        parts = []
        for segment in self.segments:
            key = self.plant.same_run(segment.recording)
            time = segment.recording.time
            blocks = ((time - time[0]) / self.plant.block).astype(int)[segment.mask]
            ids = np.array([numbers.setdefault((key, int(b)), len(numbers)) for b in blocks])
            parts += [ids for name in self.noise_floors if name in segment.recording]
        return np.concatenate(parts)


def softened(difference: np.ndarray, size: float) -> np.ndarray:
    """Differences whose squares are the soft L1 loss: unchanged well within `size`.

    Far beyond it a square grows only as the difference does (Triggs et al. 2000, section 4.3).
    """
    if not np.isfinite(size):
        return difference
    loss = 2.0 * size**2 * (np.sqrt(1.0 + (difference / size) ** 2) - 1.0)
    return np.copysign(np.sqrt(loss), difference)


def fit(
    residual: WeightedResidual,
    plant: Plant,
    start: Mapping[str, float] | None = None,
    progress: Progress = lambda text: None,
) -> Fitted:
    """Refit the free parameters of `plant` and all those of its effects, from `start`.

    Raises ComputationFailed where the machine cannot be simulated at the start.
    """
    from scipy.optimize import least_squares

    scales = _scales(plant)
    names, scale = tuple(scales), np.array(list(scales.values()))
    nominal = np.array([plant.parameters[name] for name in names])
    known = start or {}
    x = (np.array([known.get(name, plant.parameters[name]) for name in names]) - nominal) / scale
    bounds = np.array([plant.parameters.declared[name].bounds for name in names], float).T
    low, high = (bounds - nominal) / scale + [[-1e-9], [1e-9]]
    prior = np.array([1.0 if name in plant.free else 0.1 for name in names])

    def values(x: np.ndarray) -> dict[str, float]:
        return dict(zip(names, np.clip(nominal + x * scale, *bounds).tolist(), strict=True))

    def data(x: np.ndarray) -> np.ndarray:
        return residual.of(plant, values(x))

    def columns(x: np.ndarray, step: float) -> np.ndarray:
        progress(", ".join(each.name for each in plant.effects) or "baseline")
        return differences(data, x, low, high, step)

    unknown = [k for k, name in enumerate(names) if name not in plant.free and name not in known]
    residual.raw(plant, values(x))
    x = _scanned_start(data, x, unknown, low, high)
    for step in HOLDOUT.difference_steps:
        found = least_squares(
            lambda x: np.concatenate((data(x), prior * x)),
            np.clip(x, low + 1e-6, high - 1e-6),
            jac=lambda x, step=step: np.vstack((columns(x, step), np.diag(prior))),
            bounds=(low, high),
            ftol=1e-4,
            xtol=1e-4,
            max_nfev=HOLDOUT.max_evaluations,
        )
        x = found.x
    rows = found.jac[: -len(names)]
    covariance = _covariance(rows, found.fun[: -len(names)], residual.clusters(), prior)
    return Fitted(
        plant, names, values(found.x), scale, covariance * np.outer(scale, scale), rows, prior
    )


def _scanned_start(
    data: Callable[[np.ndarray], np.ndarray],
    x: np.ndarray,
    unknown: Sequence[int],
    low: np.ndarray,
    high: np.ndarray,
) -> np.ndarray:
    """Start each unknown at the best of a few sizes, one parameter after the other.

    An effect may have zero derivative at `off`: a lag far below the sampling interval does nothing.
    """
    best, left = x, np.sum(data(x) ** 2) if unknown else 0.0
    for place in unknown:
        for size in x[place] + np.array(HOLDOUT.scanned_sizes):
            moved = best.copy()
            moved[place] = np.clip(size, low[place], high[place])
            if (found := np.sum(data(moved) ** 2)) < left:
                best, left = moved, found
    return best


def _scales(plant: Plant) -> dict[str, float]:
    scales = {name: size for name, size in plant.free.items() if size > 0.0}
    for effect in plant.effects:
        scales |= free_amplitudes(effect)
    return scales


def differences(
    data: Callable[[np.ndarray], np.ndarray],
    x: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    size: float,
) -> np.ndarray:
    """Forward differences by `size`, backward at the upper bound; shape (samples, parameters).

    Backward, too, where no run succeeds ahead; zero where none does either way.
    """
    baseline, columns = data(x), []
    for place in range(x.size):
        steps = (size, -size) if x[place] + size <= high[place] else (-size, size)
        made = (_difference(data, baseline, x, place, step, (low, high)) for step in steps)
        found = (each for each in made if np.isfinite(each).all())
        columns.append(next(found, np.zeros_like(baseline)))
    return np.array(columns).T


def _difference(
    data: Callable[[np.ndarray], np.ndarray],
    baseline: np.ndarray,
    x: np.ndarray,
    place: int,
    step: float,
    bounds: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """Infinite where no run succeeds, or no step is left within the bounds."""
    moved = x.copy()
    moved[place] = np.clip(x[place] + step, *(each[place] for each in bounds))
    made = moved[place] - x[place]
    return (data(moved) - baseline) / made if made else np.full_like(baseline, np.inf)


def _covariance(
    columns: np.ndarray, rest: np.ndarray, clusters: np.ndarray, prior: np.ndarray
) -> np.ndarray:
    """The larger of two estimates for each parameter: by the weights, and by residual blocks.

    The second ("sandwich") holds although the residual is no white noise.
    """
    inverse = np.linalg.inv(columns.T @ columns + np.diag(prior**2))
    scores = np.zeros((clusters.max() + 1, columns.shape[1]))
    np.add.at(scores, clusters, columns * rest[:, np.newaxis])
    robust = inverse @ (scores.T @ scores + np.diag(prior**2)) @ inverse
    larger = np.sqrt(np.maximum(np.diag(robust), np.diag(inverse)) / np.diag(robust))
    return robust * np.outer(larger, larger)
