"""How noisy the bin means of a run are: sensors, and what sensor noise makes the machine do.

Sensor noise inside a control loop moves the machine, and friction keeps it where it came. The
residual is correlated over time and between channels, and larger at contacts. Taken as white, it
would make every fit look too certain. Its shape comes from simulations of the sampled controller
with noisy sensors, its size from them or from repeats, whichever is larger.
"""

from collections.abc import Sequence

import numpy as np

from hannes.core.recording.white_noise import roughness
from hannes.identification.diagnosis.antedependence import covariance
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.tuning import NOISE
from hannes.identification.whitening import Whitening

TYPICAL = 0.4549  # median of a squared standard normal number
Levels = dict[str, float]  # channel -> standard deviation of a bin mean


class Noise:
    """Covariance of the bin means of a run of each group, without run-to-run variability.

    deviations: of each group's runs from their mean, shape (runs, n) each: simulated ones, or
                repeats (`of_repeats`)
    roughnesses: of each channel in these; white noise makes up for that of the recordings
    nonlinearity: how many times the within-bin nonlinearity is taken as noise
    """

    def __init__(
        self,
        groups: Sequence[Group],
        deviations: Sequence[np.ndarray],
        roughnesses: Sequence[Levels],
        nonlinearities: Sequence[np.ndarray],
        run_to_run: Sequence[np.ndarray],
        nonlinearity: float,
    ) -> None:
        self.groups, self.nonlinearity = groups, nonlinearity
        self._white = {
            id(group): white_levels(
                group,
                roughness_matrix,
                NOISE.least_white_of_many
                if len(deviation) >= NOISE.many_simulations
                else NOISE.least_white_of_few,
            )
            for group, roughness_matrix, deviation in zip(
                groups, roughnesses, deviations, strict=True
            )
        }
        self._profiles = {
            id(group): _profile(group, each)
            for group, each in zip(groups, deviations, strict=True)
            if len(each)
        }
        self._strays = {id(group): each for group, each in zip(groups, deviations, strict=True)}
        self._lagged = self._correlations(deviations)
        self._correlated: dict[tuple, np.ndarray] = {}
        self._covariances: dict[int, np.ndarray] = {}
        self.more: Levels = {}
        self.more = self._compared([nonlinearity * each for each in nonlinearities], run_to_run)

    def covariance(self, group: Group) -> np.ndarray:
        """Covariance of a run, shape (n, n), positive definite."""
        levels = self._white.get(id(group)) or self._usual
        white = np.repeat([levels.get(name, 0.0) for name in group.names], group.bins)
        more = np.repeat([self.more.get(name, 1.0) for name in group.names], group.bins)
        return (np.diag(white**2) + self.moved(group)) * np.outer(more, more)

    @property
    def _usual(self) -> Levels:
        """Levels of a run that was not simulated: the largest of all."""
        names = {name for levels in self._white.values() for name in levels}
        return {n: max(each.get(n, 0.0) for each in self._white.values()) for n in names}

    def moved(self, group: Group) -> np.ndarray:
        """Covariance of what sensor noise makes the machine do, shape (n, n)."""
        if not self._lagged:
            return np.zeros((group.part.size, group.part.size))
        deviations = self._strays.get(id(group))
        if deviations is not None and len(deviations) >= NOISE.many_simulations:
            return self._per_time(group, deviations)
        kind = group.width, group.names, group.bins
        if kind not in self._correlated:
            self._correlated[kind] = self._correlation(group)
        return self._correlated[kind] * np.outer(self._profile(group), self._profile(group))

    def _per_time(self, group: Group, deviations: np.ndarray) -> np.ndarray:
        if id(group) not in self._covariances:
            self._covariances[id(group)] = covariance(deviations, len(group.names))
        return self._covariances[id(group)]

    def _correlation(self, group: Group) -> np.ndarray:
        width = min(self._lagged, key=lambda each: abs(each - group.width))
        pairs = self._lagged[width]
        roughness_matrix = np.block([[_toeplitz(pairs, a, b, group.bins) for b in group.names]
                          for a in group.names])  # fmt: skip
        values, vectors = np.linalg.eigh(0.5 * (roughness_matrix + roughness_matrix.T))
        return (vectors * np.maximum(values, NOISE.least_eigenvalue * values.mean())) @ vectors.T

    def _profile(self, group: Group) -> np.ndarray:
        """Standard deviation of each bin; of a run that was not simulated, that of the others."""
        known = self._profiles.get(id(group))
        if known is not None:
            return known
        usual = {
            name: float(np.sqrt(np.mean(np.square(self._profiles[id(each)][each.of(name)]))))
            for each in self.groups
            if id(each) in self._profiles
            for name in each.names
        }
        return np.repeat([usual.get(name, 0.0) for name in group.names], group.bins)

    def _correlations(
        self, deviations: Sequence[np.ndarray]
    ) -> dict[float, dict[tuple, np.ndarray]]:
        """Width of bin -> pair of channels -> correlation over lags, tapered."""
        runs: dict[float, list[dict[str, np.ndarray]]] = {}
        for group, rows in zip(self.groups, deviations, strict=True):
            for row in rows / np.maximum(self._profile(group), 1e-30):
                runs.setdefault(group.width, []).append({n: row[group.of(n)] for n in group.names})
        return {width: _covariances(width, each) for width, each in runs.items()}

    def _compared(self, shaken: Sequence[np.ndarray], run_to_run: Sequence[np.ndarray]) -> Levels:
        """Ratio of the spread of repeats to the model's, by channel; at least 1."""
        squares: dict[str, list[float]] = {}
        for group, *each in zip(self.groups, shaken, run_to_run, strict=True):
            level = np.sqrt(np.diag(self.covariance(group)))
            for rest in _rests(group, level, *each):
                for name in group.names:
                    ratio = (rest / level)[group.of(name)] ** 2
                    squares.setdefault(name, []).append(float(np.median(ratio)) / TYPICAL)
        return {name: max(1.0, float(np.sqrt(np.mean(each)))) for name, each in squares.items()}


def _profile(group: Group, deviations: np.ndarray) -> np.ndarray:
    """Standard deviation of each bin among runs, pooled with its neighbours, (n,)."""
    window = np.full(2 * NOISE.profile_window + 1, 1.0 / (2 * NOISE.profile_window + 1))
    variance = np.mean(np.square(deviations), axis=0).reshape(len(group.names), group.bins)
    padded = np.pad(variance, ((0, 0), (NOISE.profile_window, NOISE.profile_window)), "edge")
    smooth = [np.convolve(row, window, "valid") for row in padded]
    return np.sqrt(np.concatenate(smooth))


def of_repeats(
    groups: Sequence[Group],
    nonlinearities: Sequence[np.ndarray],
    run_to_run: Sequence[np.ndarray],
    nonlinearity: float,
) -> tuple[list[np.ndarray], list[Levels]]:
    """`deviations` and `roughnesses` for Noise, of a plant that cannot simulate sensor noise."""
    deviations, roughnesses = [], []
    for group, deviation, rows in zip(groups, nonlinearities, run_to_run, strict=True):
        levels = white_levels(group, {})
        level = np.repeat([levels[name] for name in group.names], group.bins)
        rests = _rests(group, level, nonlinearity * deviation, rows)
        deviations.append(np.array(rests).reshape(-1, group.part.size))
        roughnesses.append(recorded_roughness(group) if rests else {})
    return deviations, roughnesses


def _rests(
    group: Group, level: np.ndarray, shake: np.ndarray, run_to_run: np.ndarray
) -> list[np.ndarray]:
    """Deviation of each run from its group's mean, less the run-to-run variability."""
    if group.count < 2:
        return []
    white = Whitening.of(np.hypot(level, shake), run_to_run)
    apart = (group.measured - group.mean) * np.sqrt(group.count / (group.count - 1.0))
    return [white.rest(each) for each in apart]


def _covariances(width: float, runs: list[dict[str, np.ndarray]]) -> dict[tuple, np.ndarray]:
    shortest = min(values.size for run in runs for values in run.values())
    most = min(max(2, round(NOISE.correlation_time / width)), shortest - 1)
    lags = np.arange(most + 1)
    taper = 0.5 * (1.0 + np.cos(np.pi * lags / lags.size))
    names = sorted({name for run in runs for name in run})
    found = {}
    for a in names:
        for b in names:
            both = [(run[a], run[b]) for run in runs if a in run and b in run]
            size = sum(x.size for x, _ in both)
            if size:  # runs one after the other, too far apart to be seen together
                x, y = (np.concatenate([np.pad(e[k], (0, most)) for e in both]) for k in (0, 1))
                sums = [float(x[: x.size - lag] @ y[lag:]) for lag in lags]
                found[a, b] = taper * np.array(sums) / size
    return found


def _toeplitz(pairs: dict[tuple, np.ndarray], a: str, b: str, size: int) -> np.ndarray:
    from scipy.linalg import toeplitz

    if (a, b) not in pairs:
        return np.zeros((size, size))
    later, earlier = np.zeros(size), np.zeros(size)
    count = min(size, pairs[a, b].size)
    later[:count], earlier[:count] = pairs[a, b][:count], pairs[b, a][:count]
    return toeplitz(earlier, later)


def white_levels(group: Group, known: Levels, least: float = NOISE.least_white_of_few) -> Levels:
    """White noise of each channel's bin means beyond one of known roughness.

    least: share of the roughness that is white in any case
    """
    found = {}
    for name, level_recorded in recorded_roughness(group).items():
        samples = group.views[0].samples(name)
        more = np.sqrt(
            max(
                level_recorded**2 - (NOISE.roughness_accuracy * known.get(name, 0.0)) ** 2,
                (least * level_recorded) ** 2,
            )
        )
        level = float(more) / np.sqrt(samples.size / group.bins)
        found[name] = max(level, 1e-6 * float(np.abs(samples).max()), 1e-12)
    return found


def recorded_roughness(group: Group) -> Levels:
    """Roughness of each channel's samples, in the middle of its runs."""
    runs = {name: [view.samples(name) for view in group.views] for name in group.names}
    return {name: float(np.median([roughness(x) for x in each])) for name, each in runs.items()}
