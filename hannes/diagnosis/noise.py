"""What repeats of one run differ in beyond what the machine does from run to run: its covariance.

A noisy sensor inside a control loop moves the machine, so that what is left hangs together over
time and from channel to channel: counted as white, it would make every fit surer than it may be.
"""

from collections.abc import Sequence

import numpy as np

from hannes.calibration.whitening import Whitening
from hannes.diagnosis.groups import Group

REACH = 0.2  # s, over which noise hangs together
LEAST = 0.2  # of the mean eigenvalue: a covariance from a few runs has none that is surely less
TYPICAL = 0.4549  # median of a squared standard normal number
Levels = dict[str, float]  # channel -> standard deviation of a bin mean


class Noise:
    """Covariance of the bin means of a run of each group, without grain and jerk."""

    def __init__(
        self,
        groups: Sequence[Group],
        jerks: Sequence[np.ndarray],
        restless: Sequence[np.ndarray],
        floor: Levels,
    ) -> None:
        self.groups, self.floor = groups, floor
        self._rests = [_rests(*each, floor) for each in zip(groups, jerks, restless, strict=True)]
        self.levels = self._levels()
        self._lagged = self._correlations(jerks)

    def _levels(self) -> Levels:
        """Of every channel, from the median over bins: a few odd bins change little."""
        squares: dict[str, list[float]] = {}
        for group, rests in zip(self.groups, self._rests, strict=True):
            for rest in rests:
                for name in group.names:
                    typical = float(np.median(rest[group.of(name)] ** 2)) / TYPICAL
                    squares.setdefault(name, []).append(typical)
        found = {name: float(np.sqrt(np.mean(each))) for name, each in squares.items()}
        return {name: max(found.get(name, 0.0), least) for name, least in self.floor.items()}

    def _deviations(self, group: Group) -> np.ndarray:
        return np.repeat([self.levels[name] for name in group.names], group.bins)

    def _correlations(self, jerks: Sequence[np.ndarray]) -> dict[float, dict[tuple, np.ndarray]]:
        """Width of bin -> pair of channels -> covariance over lags, tapered."""
        runs: dict[float, list[dict[str, np.ndarray]]] = {}
        for group, rests, jerk in zip(self.groups, self._rests, jerks, strict=True):
            level = self._deviations(group)
            for rest in rests:
                calm = rest * level / np.hypot(level, JERK * jerk)
                parts = {name: calm[group.of(name)] for name in group.names}
                runs.setdefault(group.width, []).append(parts)
        return {width: _covariances(width, each) for width, each in runs.items()}

    def covariance(self, group: Group) -> np.ndarray:
        """Shape (n, n), positive definite."""
        level = self._deviations(group)
        if not self._lagged:
            return np.diag(level**2)
        width = min(self._lagged, key=lambda each: abs(each - group.width))
        pairs = self._lagged[width]
        rough = np.block([[_toeplitz(pairs, a, b, group.bins) for b in group.names]
                          for a in group.names])  # fmt: skip
        level = np.sqrt(np.maximum(level**2, np.diag(rough)))
        values, vectors = np.linalg.eigh(0.5 * (rough + rough.T) / np.outer(level, level))
        sound = (vectors * np.maximum(values, LEAST)) @ vectors.T
        return sound * np.outer(level, level)


JERK = 10.0  # times the stray inside a bin is noise there: what touches is not known to the bin


def _rests(group: Group, jerk: np.ndarray, restless: np.ndarray, floor: Levels) -> list[np.ndarray]:
    """What each run differs in from the mean of its group, what runs do taken away."""
    if group.count < 2:
        return []
    level = np.repeat([floor[name] for name in group.names], group.bins)
    white = Whitening.of(np.hypot(level, JERK * jerk), restless)
    apart = (group.measured - group.mean) * np.sqrt(group.count / (group.count - 1.0))
    return [white.rest(each) for each in apart]


def _covariances(width: float, runs: list[dict[str, np.ndarray]]) -> dict[tuple, np.ndarray]:
    lags = np.arange(max(2, round(REACH / width)) + 1)
    taper = 0.5 * (1.0 + np.cos(np.pi * lags / lags.size))
    names = sorted({name for run in runs for name in run})
    found = {}
    for a in names:
        for b in names:
            both = [(run[a], run[b]) for run in runs if a in run and b in run]
            size = sum(x.size for x, _ in both)
            if size:
                sums = [sum(float(x[: x.size - lag] @ y[lag:]) for x, y in both) for lag in lags]
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


def rough_levels(groups: Sequence[Group]) -> Levels:
    """Least noise of each channel's bin means: from how rough its samples are."""
    found: dict[str, float] = {}
    for group in groups:
        for view in group.views:
            for name in group.names:
                samples = view.samples(name)
                rough = 1.4826 * float(np.median(np.abs(np.diff(samples, 2)))) / np.sqrt(6.0)
                level = rough / np.sqrt(samples.size / group.bins)
                least = max(0.3 * level, 1e-6 * float(np.abs(samples).max()), 1e-12)
                found[name] = max(found.get(name, 0.0), least)
    return found
