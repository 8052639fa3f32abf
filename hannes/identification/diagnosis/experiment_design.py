"""The run most worth recording next: the one on which two explanations differ most.

Each proposed run is simulated with both explanations as fitted. Their difference counts in
standard deviations of everything uncertain there: sensors, discretisation, run-to-run variability,
and the machine as far as the recordings leave it open. Channels that were not logged so far are
asked for only where no run without them separates the two.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.campaigns.campaign import Entry, following
from hannes.core.errors import ComputationFailed
from hannes.core.recording.recording import Recording
from hannes.core.recording.white_noise import roughness
from hannes.identification.diagnosis.linearisation import Linearisation, differenced
from hannes.identification.diagnosis.noise_covariance import (
    NoiseAccuracy,
    estimated_noise,
    run_to_run_rows,
)
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.trials import SearchResult, Trial
from hannes.identification.diagnosis.tuning import NOISE, VERDICT
from hannes.identification.effect_words import effect_words
from hannes.plants.protocol import Plant

BRIEF = NoiseAccuracy(NOISE.fine_nonlinearity, NOISE.proposed_samples)
AND = " with "  # between effects that explain together
Proposals = Callable[[Mapping[str, Recording]], Mapping[str, Recording]]


@dataclass(frozen=True)
class Separation:
    """How well a run separates two explanations, in standard deviations.

    usual: by the channels that are logged so far;  most: by those in `more` too
    """

    usual: float
    most: float
    more: tuple[str, ...] = ()


def next_run(
    plant: Plant, found: SearchResult, entries: Sequence[Entry], names: Mapping[str, str]
) -> dict | None:
    """The run to record next, what it separates, and why; None where none is worth it.

    A plant may lack `proposals`. names: effect -> name by which it can be found again
    """
    proposals: Proposals | None = getattr(plant, "proposals", None)
    pair = explanations(found)[:2]
    if proposals is None or len(pair) < 2:
        return None
    recorded: dict[str, Recording] = {}
    for each in entries:
        recorded.setdefault(each.condition, each.recording)
    made = proposals(recorded)
    runs = {name: following(entries, Entry(name, run, name)) for name, run in made.items()}
    separations = {
        name: separation(found, plant, run, list(recorded.values()), *pair)
        for name, run in runs.items()
    }
    best = proposed(separations, [AND.join(trial.effects) for trial in pair])
    found_again = [AND.join(names.get(name, name) for name in trial.effects) for trial in pair]
    return best and {**best, "separates": found_again}


def explanations(found: SearchResult) -> list[Trial]:
    """What may explain the recordings, best first: several effects together, single ones.

    A part of the best one is no other explanation.
    """
    joint = [found.joint.trial, *found.joint.others] if found.joint else []
    every = [*joint, *found.trials, *([found.generic] if found.generic else [])]
    every.sort(key=lambda each: -each.delta_chi2)
    parts = [set(each.effects) < set(every[0].effects) for each in every]
    return [each for each, part in zip(every, parts, strict=True) if not part]


def proposed(separations: Mapping[str, Separation], names: list[str]) -> dict | None:
    """The run that separates best by what is logged so far, or with more channels if needed."""
    apart = " from ".join(effect_words(name) for name in names)
    best = max(separations, key=lambda name: separations[name].usual, default="")
    if best and separations[best].usual >= VERDICT.enough_separation:
        by = _counted(separations[best].usual)
        why = f"it would separate {apart} by {by} standard deviations"
        return {"experiment": best, "also_log": [], "separates": names, "why": why}
    best = max(separations, key=lambda name: separations[name].most, default="")
    if not best or separations[best].most < VERDICT.least_separation:
        return None
    each = separations[best]
    why = f"it would separate {apart} by {_counted(each.most)} standard deviations"
    more = each.more if each.most > each.usual + VERDICT.worth_logging else ()
    if more:
        why += f", without {' and '.join(more)} by {_counted(each.usual)}"
    return {"experiment": best, "also_log": list(more), "separates": names, "why": why}


def _counted(deviations: float) -> str:
    """`7.6`, `2,178`."""
    return f"{deviations:.1f}" if deviations < 100.0 else f"{deviations:,.0f}"


def separation(
    found: SearchResult, plant: Plant, entry: Entry, recorded: Sequence[Recording], *pair: Trial
) -> Separation:
    """Separation of two explanations by one more run; zero where it cannot be simulated."""
    baseline, run, more = found.baseline, entry.recording, {}
    if baseline.noise.simulated_noise:
        more = {n: u for n, u in getattr(plant, "loggable", {}).items() if n not in run}
        run = _rough(plant, run, recorded, more)
    group, there = Group(plant, [replace(entry, recording=run)]), baseline.model
    model = Model(there.small, [group], there.space, (), there.work, there.bandwidth)
    model.whole = there.whole
    try:
        for trial in pair:
            model = model.with_sampling_correction(trial.point.x, trial.effects)
        difference, uncertainty = _differing(baseline, model, group, *pair)
    except ComputationFailed:
        return Separation(0.0, 0.0)
    uncertainty *= found.variance_factor
    usual = np.repeat([name not in more for name in group.names], group.bins)
    return Separation(
        _distance(difference[usual], uncertainty[np.ix_(usual, usual)]),
        _distance(difference, uncertainty),
        tuple(name for name in group.names if name in more),
    )


def _differing(
    baseline: Linearisation, model: Model, group: Group, one: Trial, other: Trial
) -> tuple[np.ndarray, np.ndarray]:
    """Difference of two explanations, shape (n,), and the covariance of what is uncertain."""
    known = model.space.uncertain
    vectors, derivatives = differenced(model, baseline.x, known, False)
    ends = model.vectors(group, np.array([one.point.x, other.point.x]), True)
    channels = model.simulated(group, baseline.x[np.newaxis], False)[0]
    if channels is None or not (np.isfinite(ends).all() and np.isfinite(vectors[0]).all()):
        raise ComputationFailed(f"{group.entries[0].name} cannot be simulated")
    open_left = np.linalg.solve(baseline.hessian[: known.size, : known.size], derivatives[0])
    return ends[0] - ends[1], _uncertainty(baseline, model, channels) + derivatives[0].T @ open_left


def _distance(difference: np.ndarray, covariance: np.ndarray) -> float:
    return float(np.sqrt(difference @ np.linalg.solve(covariance, difference)))


def _uncertainty(
    baseline: Linearisation, model: Model, channels: Mapping[str, np.ndarray]
) -> np.ndarray:
    """Covariance of a run by everything uncertain but the machine."""
    noise, (group,) = baseline.noise.run_noise, model.groups
    if baseline.noise.simulated_noise:  # repeats may be noisier than simulated ones
        more = np.repeat([noise.more.get(name, 1.0) for name in group.names], group.bins)
        return estimated_noise(model, baseline.x, BRIEF, 0).covariances[0] * np.outer(more, more)
    rows, nonlinearity = (
        run_to_run_rows(model, baseline.x, group, channels),
        group.nonlinearity(channels),
    )
    return (
        noise.covariance(group) + np.diag((noise.nonlinearity * nonlinearity) ** 2) + rows.T @ rows
    )


def _rough(
    plant: Plant, run: Recording, recorded: Sequence[Recording], more: Mapping[str, str]
) -> Recording:
    """The run with further channels, and with recorded channels as noisy as they were.

    Noise is simulated in it accordingly.
    """
    rng, channels = np.random.default_rng(0), dict(run.channels)
    for name in plant.judged:
        levels = [roughness(each[name]) for each in recorded if name in each]
        if name in run and levels:
            channels[name] = np.median(levels) * rng.standard_normal(run.time.size)
    channels |= {name: np.zeros(run.time.size) for name in more}
    return replace(run, channels=channels, units={**run.units, **more})
