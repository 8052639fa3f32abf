"""How much more runs under one command differ than they were told to, as their repeats show.

Told too little of it, means of a few runs seem surer than they are: six that by chance all started
late are a delay then.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from hannes.identification.diagnosis.linearisation import NoiseCovariance
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.tuning import NOISE

# As far as told: the machine's values, and the start.


def settings_from_repeats(noise: NoiseCovariance, settings: Settings) -> Settings:
    """The settings where repeats agree with them; else what these show, and twice the scatter.

    Nothing shows how far the machine's values are off. Who knows runs too well knows these no
    better, so that a name has to hold where they are less well known.
    """
    machine, start = observed_ratios(noise)
    if (machine, start) == (1.0, 1.0):
        return settings
    return Settings(
        max(settings.scatter, min(NOISE.wider_scatter * settings.scatter, NOISE.widest_scatter)),
        machine * settings.run_scatter,
        start * settings.start_time,
    )


def disagreement(assumed: Settings, observed: Settings) -> list[str]:
    """What a reader must know where repeats did not agree with what was told."""
    if assumed == observed:
        return []
    return [
        f"repeats differ further than [diagnose] tells: run_scatter {observed.run_scatter:.2g} and "
        f"start_time {observed.start_time:.2g} s were taken, as they show, and scatter "
        f"{observed.scatter:.2g} to be safe"
    ]


def observed_ratios(noise: NoiseCovariance) -> tuple[float, float]:
    """How many times as far as told runs differ, in the machine's values and in their start.

    The likeliest pair of all; 1 where repeats do not surely show more, and where nothing but they
    tells how noisy runs are.
    """
    repeats = [
        _Repeats.of(group, covariance * group.count - rows.T @ rows, rows)
        for group, covariance, rows in zip(
            noise.model.groups, noise.covariances, noise.run_to_run, strict=True
        )
        if group.count > 1 and noise.simulated_noise
    ]
    pairs = list(product(NOISE.excess_ratios, NOISE.excess_ratios))
    likelihoods = [sum(each.log_likelihood(*pair) for each in repeats) for pair in pairs]
    best = int(np.argmax(likelihoods))
    gained = 2.0 * (likelihoods[best] - likelihoods[pairs.index((1.0, 1.0))])
    return pairs[best] if gained >= NOISE.excess_likelihood else (1.0, 1.0)


@dataclass(frozen=True)
class _Repeats:
    """What runs of one group are off their mean, along what they may differ in.

    along: of each of `freedom` independent differences, (freedom, k); stiff: of rows with each
    other, (k, k); both in the noise of a run that is steady
    """

    along: np.ndarray
    stiff: np.ndarray

    @classmethod
    def of(cls, group: Group, steady: np.ndarray, rows: np.ndarray) -> "_Repeats":
        """steady: covariance of a run without what runs differ in, rows: that, the start last."""
        from scipy.linalg import helmert, solve_triangular

        root = np.linalg.cholesky(steady)
        apart = helmert(group.count) @ group.measured  # independent, each as noisy as a run
        runs, rows = (solve_triangular(root, each.T, lower=True).T for each in (apart, rows))
        return cls(runs @ rows.T, rows @ rows.T)

    def log_likelihood(self, machine: float, start: float) -> float:
        """Of differences so many times as far, beyond a constant."""
        sizes = _sizes(self.stiff, machine, start)
        along = self.along * sizes
        whole = np.eye(sizes.size) + self.stiff * np.outer(sizes, sizes)
        explained = float(np.sum(along * np.linalg.solve(whole, along.T).T))
        return 0.5 * (explained - len(along) * float(np.linalg.slogdet(whole)[1]))


def _sizes(rows: np.ndarray, machine: float, start: float) -> np.ndarray:
    return np.append(np.full(len(rows) - 1, machine), start)
