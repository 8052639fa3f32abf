"""The hold-out test of one effect: fitted on some segments, judged on others."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import ComputationFailed
from hannes.core.parameter import Parameter
from hannes.identification.holdout.least_squares import Fitted, Progress, WeightedResidual, fit
from hannes.identification.holdout.tuning import HOLDOUT

POWER_80 = 3.42  # standard deviations seen with 80 % power at ALPHA, two-sided: 2.576 + 0.842


@dataclass(frozen=True)
class Trial:
    """The outcome of one effect; `why` states why it was not accepted.

    delta_chi2:  mean reduction of squared residuals on the validation segments, noise floor = 1
    share:       the same as a share of what was above the noise floor
    lower_limit: of the blocks' mean log reduction, by resampling blocks
    evidence:    distance of its parameters from `off`, in standard deviations
    """

    name: str
    effect: Effect
    why: str = ""
    fitted: Fitted | None = None
    delta_chi2: float = 0.0
    share: float = 0.0
    lower_limit: float = 0.0
    evidence: float = 0.0
    block_reductions: np.ndarray = field(default_factory=lambda: np.zeros(0), repr=False)
    confusable_with: tuple[str, ...] = ()

    @property
    def accepted(self) -> bool:
        """True where nothing contradicts it."""
        return self.fitted is not None and not self.why

    @property
    def applicable(self) -> bool:
        """True where the plant can carry it."""
        return self.fitted is not None


def tried(
    name: str,
    effect: Effect,
    training: WeightedResidual,
    baseline: Fitted,
    validation: WeightedResidual,
    rng: np.random.Generator,
    progress: Progress,
) -> Trial:
    """One effect fitted and judged; not applicable where its start, or a run to judge it, fails."""
    try:
        extended = training.plant.with_effects(effect)
        trial = Trial(name, effect, fitted=fit(training, extended, baseline.values, progress))
        if not validation.segments:
            return replace(trial, why="no recording is left to choose by")
        return judge(trial, validation, baseline, rng)
    except ComputationFailed as failed:
        return Trial(name, effect, f"not applicable: a run with it fails: {failed}")


def judge(
    trial: Trial, residual: WeightedResidual, before: Fitted, rng: np.random.Generator
) -> Trial:
    """Return the trial with its reduction on the segments of `residual`, and the outcome."""
    fitted = trial.fitted
    assert fitted is not None
    old, new = (_squares(residual, f) for f in (before, fitted))
    reductions = _block_reductions(old, new, residual.clusters())
    drawn = rng.integers(0, reductions.size, (HOLDOUT.resamples, reductions.size))
    delta_chi2 = float((old - new).mean())
    judged = replace(
        trial,
        delta_chi2=delta_chi2,
        share=delta_chi2 / max(float(old.mean()) - 1.0, abs(delta_chi2), 1e-12),
        lower_limit=float(np.quantile(reductions[drawn].mean(1), HOLDOUT.false_alarms)),
        evidence=evidence(fitted, trial.effect),
        block_reductions=reductions,
    )
    return replace(judged, why=_objection(judged))


def _block_reductions(old: np.ndarray, new: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    """Logarithm of the factor by which an effect divides each block's mean square, floor added.

    So no single block, however bad before, decides alone.
    """
    counts = np.bincount(blocks)
    there = counts > 0
    before, after = (np.bincount(blocks, each)[there] / counts[there] for each in (old, new))
    return np.log((before + 1.0) / (after + 1.0))


def _squares(residual: WeightedResidual, fitted: Fitted) -> np.ndarray:
    """Squared residual of every sample in units of the noise floor."""
    raw = residual.raw(fitted.plant, fitted.values)
    return np.concatenate(
        [(v / residual.noise_floors[n]) ** 2 for channels in raw for n, v in channels.items()]
    )


def evidence(fitted: Fitted, effect: Effect) -> float:
    """Distance of the effect's amplitudes from `off`, in standard deviations (Mahalanobis)."""
    names = [effect.full_name(each.name) for each in effect.amplitudes]
    away = np.array(
        [fitted.values[n] - (e.off or 0.0) for n, e in zip(names, effect.amplitudes, strict=True)]
    )
    places = [fitted.names.index(name) for name in names]
    covariance = fitted.covariance[np.ix_(places, places)]
    squared = float(away @ np.linalg.solve(covariance, away))
    return float(np.sqrt(max(0.0, squared)))


def _objection(trial: Trial) -> str:
    from scipy.stats import chi2

    needed = float(np.sqrt(chi2.ppf(1.0 - HOLDOUT.false_alarms, len(trial.effect.amplitudes))))
    if trial.block_reductions.size < HOLDOUT.fewest_blocks:
        return (
            f"only {trial.block_reductions.size} blocks to judge by, "
            f"{HOLDOUT.fewest_blocks} are needed"
        )
    if trial.lower_limit <= 0.0:
        return "its improvement on recordings not fitted is within chance"
    if trial.delta_chi2 < HOLDOUT.least_reduction or trial.share < HOLDOUT.least_share:
        return f"it explains only {100 * trial.share:.0f} % of what is above the noise floor"
    if trial.evidence < needed:
        return (
            f"its size lies {trial.evidence:.3f} standard deviations from none, "
            f"{needed:.3f} are needed"
        )
    return ""


def ranked(trials: Sequence[Trial]) -> list[Trial]:
    """Best first: accepted ones by reduction, then the others likewise, inapplicable ones last."""
    return sorted(trials, key=lambda t: (not t.accepted, not t.applicable, -t.delta_chi2, t.name))


def with_confusable(trials: Sequence[Trial]) -> list[Trial]:
    """Return the trials, each with the names of those it is easily confused with here."""
    spaces = {trial.name: _signature(trial) for trial in trials if trial.applicable}
    return [
        replace(
            trial,
            confusable_with=tuple(
                name
                for name, space in spaces.items()
                if trial.name in spaces
                and name != trial.name
                and _cosine(space, spaces[trial.name]) > HOLDOUT.confusable_cosine
            ),
        )
        for trial in trials
    ]


def _signature(trial: Trial) -> np.ndarray:
    """Orthonormal basis of the effect's signature, beyond what the baseline absorbs."""
    fitted = trial.fitted
    assert fitted is not None
    amplitudes = {trial.effect.full_name(each.name) for each in trial.effect.amplitudes}
    own = [name in amplitudes for name in fitted.names]
    mine = fitted.columns[:, own]
    theirs = fitted.columns[:, [n in fitted.plant.free for n in fitted.names]]
    prior = fitted.prior[[n in fitted.plant.free for n in fitted.names]]
    absorbed = np.linalg.solve(theirs.T @ theirs + np.diag(prior**2), theirs.T @ mine)
    left = mine - theirs @ absorbed
    size = np.linalg.norm(left, axis=0)
    return np.linalg.qr(left[:, size > 1e-9 * max(size.max(), 1e-30)])[0]


def _cosine(one: np.ndarray, other: np.ndarray) -> float:
    if one.size == 0 or other.size == 0 or one.shape[0] != other.shape[0]:
        return 0.0
    return float(np.linalg.svd(one.T @ other, compute_uv=False)[0])


def rivals(best: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """Accepted trials that reduce nearly as much as the best, so that no choice can be made."""
    return [
        each
        for each in trials
        if each is not best
        and each.accepted
        and each.delta_chi2 >= HOLDOUT.rival_share * best.delta_chi2
    ]


def minimum_detectable_sizes(trials: Sequence[Trial]) -> dict[str, dict[str, dict[str, Any]]]:
    """Effect and amplitude -> size seen with 80 % power at the false-alarm level, linearly.

    `value` is None, with the `reason`, where no size inside the physical bounds would be seen.
    """
    return {
        trial.name: {
            each.name: _detectable(each, trial.fitted.deviation(trial.effect.full_name(each.name)))
            for each in trial.effect.amplitudes
        }
        for trial in trials
        if trial.fitted is not None
    }


def _detectable(amplitude: Parameter, deviation: float) -> dict[str, Any]:
    size, off = POWER_80 * deviation, amplitude.off or 0.0
    largest = max(amplitude.bounds[1] - off, off - amplitude.bounds[0])
    if size <= largest:
        return {"value": size, "unit": amplitude.unit}
    reason = (
        f"even the largest size inside its bounds, {largest:g}, would be missed: "
        f"these recordings would show {size:.2g}"
    )
    return {"value": None, "unit": amplitude.unit, "reason": reason}
