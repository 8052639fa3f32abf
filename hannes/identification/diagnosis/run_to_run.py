"""How much runs under one command differ beside what the settings assume, as their repeats show.

Assumed too small, means of a few runs seem more certain than they are. Six runs that happened to
start late would then be a delay. Assumed too large, what all runs share is taken for chance: a fit
leaves it, although no repeat strays so far.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from hannes.identification.diagnosis.noise_covariance import NoiseCovariance
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.tuning import NOISE


def settings_from_repeats(noise: NoiseCovariance, settings: Settings) -> Settings:
    """The settings where repeats agree with them; else what repeats show, where that is more with
    twice the scatter.

    Nothing shows how far the machine's parameters are off. Whoever assumes too little run-to-run
    variability may assume too little scatter as well, so a name must hold with more of it.
    """
    machine, start = observed_ratios(noise)
    if (machine, start) == (1.0, 1.0):
        return settings
    wider = min(NOISE.wider_scatter * settings.scatter, NOISE.widest_scatter)
    more = max(machine, start) > 1.0
    return replace(
        settings,
        scatter=max(settings.scatter, wider) if more else settings.scatter,
        run_scatter=machine * settings.run_scatter,
        start_time=start * settings.start_time,
    )


def disagreement(assumed: Settings, observed: Settings) -> list[str]:
    """What a reader must know where repeats disagree with the assumed settings."""
    if assumed == observed:
        return []
    taken = f"run_scatter {observed.run_scatter:.2g} and start_time {observed.start_time:.2g} s"
    if assumed.scatter == observed.scatter and not _more(assumed, observed):
        return [f"repeats differ less than [diagnose] assumes: {taken} were taken from them"]
    return [
        f"repeats differ further than [diagnose] assumes: {taken} were taken from them, and "
        f"scatter {observed.scatter:.2g} to be safe"
    ]


def _more(assumed: Settings, observed: Settings) -> bool:
    return observed.run_scatter > assumed.run_scatter or observed.start_time > assumed.start_time


def observed_ratios(noise: NoiseCovariance) -> tuple[float, float]:
    """Ratios of observed to assumed run-to-run variability, of parameters and of start times.

    The most likely pair; where that is less, the largest ratios that are nearly as likely. 1 where
    repeats do not surely show another one, and where noise is known from them alone.
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
    ratio = 2.0 * (likelihoods[best] - likelihoods[pairs.index((1.0, 1.0))])
    if ratio < NOISE.excess_likelihood:
        return 1.0, 1.0
    if max(pairs[best]) > 1.0:
        return pairs[best]
    lost = 2.0 * (likelihoods[best] - np.array(likelihoods))
    near = np.array(pairs)[lost < NOISE.nearly_as_likely]
    machine, start = np.minimum(near.max(axis=0), 1.0).tolist()
    return machine, start


@dataclass(frozen=True)
class _Repeats:
    """Deviations of a group's runs from their mean, along the run-to-run variability.

    along: of each of `freedom` independent differences, (freedom, k)
    stiff: products of the rows, (k, k); both whitened by the noise of a steady run
    """

    along: np.ndarray
    stiff: np.ndarray

    @classmethod
    def of(cls, group: Group, steady: np.ndarray, rows: np.ndarray) -> "_Repeats":
        """steady: covariance of a run that does not vary; rows: variability, start time last."""
        from scipy.linalg import helmert, solve_triangular

        root = np.linalg.cholesky(steady)
        apart = helmert(group.count) @ group.measured  # independent, each as noisy as a run
        runs, rows = (solve_triangular(root, each.T, lower=True).T for each in (apart, rows))
        return cls(runs @ rows.T, rows @ rows.T)

    def log_likelihood(self, machine: float, start: float) -> float:
        """Log-likelihood of variability larger by these ratios, up to a constant."""
        sizes = _sizes(self.stiff, machine, start)
        along = self.along * sizes
        whole = np.eye(sizes.size) + self.stiff * np.outer(sizes, sizes)
        explained = float(np.sum(along * np.linalg.solve(whole, along.T).T))
        return 0.5 * (explained - len(along) * float(np.linalg.slogdet(whole)[1]))


def _sizes(rows: np.ndarray, machine: float, start: float) -> np.ndarray:
    return np.append(np.full(len(rows) - 1, machine), start)
