"""Reduction on held-out runs: baseline and effect are refitted without them."""

from collections.abc import Sequence

import numpy as np

from hannes.identification.diagnosis.gauss_newton import fitted
from hannes.identification.diagnosis.linearisation import Linearisation, with_noise
from hannes.identification.diagnosis.noise_covariance import NoiseCovariance
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.tuning import FIT, VERDICT


def runs_in_role(groups: Sequence[Group], role: str) -> list[int]:
    """Bit mask of the runs of each group that have a role."""
    return [
        sum(1 << k for k, entry in enumerate(group.entries) if entry.role == role)
        for group in groups
    ]


def stands_on_heldout(fewer: Linearisation, more: Linearisation) -> bool:
    """Whether the misfit of held-out runs does not rise by a further effect.

    So where none are held out, or none can be run; what fits converge to is no rise.
    """
    fitted_runs, heldout_runs = (
        runs_in_role(fewer.model.groups, role) for role in ("fit", "select")
    )
    if not (any(fitted_runs) and any(heldout_runs)):
        return True
    return not heldout_reduction(fewer, more, fitted_runs, heldout_runs) < -FIT.converged


def heldout_reduction(
    baseline: Linearisation,
    trial: Linearisation,
    fitted_runs: Sequence[int],
    heldout_runs: Sequence[int],
) -> float:
    """Chi-squared of the baseline less that of the trial on runs that were not fitted.

    fitted_runs, heldout_runs: bit masks of the runs of each group. Zero where either has none.
    """
    if not (any(fitted_runs) and any(heldout_runs)):
        return 0.0
    return _left(baseline, fitted_runs, heldout_runs) - _left(trial, fitted_runs, heldout_runs)


def _left(point: Linearisation, fitted_runs: Sequence[int], heldout_runs: Sequence[int]) -> float:
    """Chi-squared on held-out runs, after a fit of the others; infinite where it cannot be run."""
    found = fitted(_only(point, fitted_runs), VERDICT.heldout_steps)
    there = _only(point, heldout_runs).moved(found.x, np.zeros(0, int))
    return float("inf") if there is None else float(there.residual @ there.residual)


def _only(point: Linearisation, masks: Sequence[int]) -> Linearisation:
    """The point with some of the runs alone: means of fewer runs are noisier."""
    noise, numbers = point.noise, [k for k, mask in enumerate(masks) if mask]
    whole = [noise.model.groups[k] for k in numbers]
    groups = [
        group.only([n for n in range(group.count) if masks[k] >> n & 1])
        for k, group in zip(numbers, whole, strict=True)
    ]
    covariances = [
        noise.covariances[k] * (old.count / new.count)
        for k, old, new in zip(numbers, whole, groups, strict=True)
    ]
    discretisation = [noise.discretisation[k] for k in numbers]
    model, rows = noise.model.of(groups, numbers), [noise.run_to_run[k] for k in numbers]
    some = NoiseCovariance(
        model, noise.run_noise, discretisation, covariances, rows, noise.simulated_noise,
        noise.parts and noise.parts.only(numbers),
    )  # fmt: skip
    vectors, derivatives = (
        [each[k] for k in numbers] for each in (point.vectors, point.derivatives)
    )
    return with_noise(point, some, vectors, derivatives)
