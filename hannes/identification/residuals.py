"""How far simulation and recordings are apart: in all, by channel and phase, and over time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.campaigns.segments import Segment
from hannes.core.by_value import ByValue
from hannes.identification.holdout.least_squares import Fitted, WeightedResidual
from hannes.plants.protocol import Plant

WORST = 12  # places of the where-map that are kept
Raw = Sequence[Mapping[str, np.ndarray]]  # of each segment: channel -> simulated minus recorded


@dataclass(frozen=True, eq=False)
class Traces(ByValue):
    """One recording and three simulations of it: channel -> array, shape (n,)."""

    entry: Entry
    time: np.ndarray
    mask: np.ndarray
    measured: dict[str, np.ndarray]
    as_given: dict[str, np.ndarray]
    before: dict[str, np.ndarray]
    after: dict[str, np.ndarray]


def gaps(residual: WeightedResidual, before: Fitted, after: Fitted) -> dict[str, dict[str, Any]]:
    """RMS of each channel as given, of the baseline fit, with the effect; and its noise floor."""
    stages = {
        "as_given": residual.raw(residual.plant, {}),
        "before": residual.raw(before.plant, before.values),
        "after": residual.raw(after.plant, after.values),
    }
    return tabled(stages, residual.segments, residual.plant.channels, residual.noise_floors)


def tabled(
    stages: Mapping[str, Raw],
    segments: Sequence[Segment],
    units: Mapping[str, str],
    noise_floors: Mapping[str, float],
) -> dict[str, dict[str, Any]]:
    """The same from what each stage leaves of every segment."""
    sizes = {key: pooled(raw, noise_floors) for key, raw in stages.items()}
    return {
        name: {"unit": units[name]}
        | {key: sizes[key][name] for key in stages}
        | {"floor": noise_floors[name]}
        | {f"{key}_percent": relative(raw, segments, name) for key, raw in stages.items()}
        for name in sizes["before"]
    }


def without_effect(gap: Mapping[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """The same gaps where no effect is named: after is the same as before."""
    return {
        name: {**each, "after": each["before"], "after_percent": each["before_percent"]}
        for name, each in gap.items()
    }


def where(residual: WeightedResidual, fitted: Fitted) -> list[dict[str, Any]]:
    """Channel and phase of a fit's residual, worst first."""
    raw = residual.raw(fitted.plant, fitted.values)
    return located(residual.plant, residual.segments, raw, residual.noise_floors)


def located(
    plant: Plant, segments: Sequence[Segment], raw: Raw, noise_floors: Mapping[str, float]
) -> list[dict[str, Any]]:
    """Channel and phase of simulated minus recorded, worst first."""
    places: dict[tuple[str, str], list[tuple[np.ndarray, np.ndarray, str]]] = {}
    for segment, channels in zip(segments, raw, strict=True):
        time = segment.recording.time[segment.mask]
        for phase, mask in plant.phases(segment.recording).items():
            inside = mask[segment.mask]
            for name, values in channels.items():
                if inside.any():
                    found = (values[inside], time[inside], segment.entry.name)
                    places.setdefault((name, phase), []).append(found)
    rows = [_located(*key, parts, noise_floors) for key, parts in places.items()]
    return sorted(rows, key=lambda row: -row["times_floor"])[:WORST]


def _located(
    name: str,
    phase: str,
    parts: Sequence[tuple[np.ndarray, np.ndarray, str]],
    noise_floors: Mapping[str, float],
) -> dict[str, Any]:
    size = float(np.sqrt(np.mean(np.concatenate([part[0] for part in parts]) ** 2)))
    return {
        "channel": name,
        "phase": phase,
        "t0": float(min(part[1][0] for part in parts)),
        "t1": float(max(part[1][-1] for part in parts)),
        "rms": size,
        "times_floor": size / noise_floors[name],
        "recordings": list(dict.fromkeys(part[2] for part in parts)),
    }


def traces(
    plant: Plant, entry: Entry, before: Fitted, after: Fitted, noise_floors: Mapping[str, float]
) -> Traces:
    """Simulate one recording as given, with the baseline refitted, with the effect."""
    recording = entry.recording
    runs = (
        plant.simulate({}, recording),
        before.plant.simulate(before.values, recording),
        after.plant.simulate(after.values, recording),
    )
    names = [name for name in noise_floors if name in recording]
    measured = {name: recording[name] for name in names}
    simulated = ({name: run[name] for name in names} for run in runs)
    return Traces(entry, recording.time, plant.judged_part(recording), measured, *simulated)


def times_noise_floor(
    residual: WeightedResidual, plant: Plant, values: Mapping[str, float]
) -> float:
    """RMS of the worst channel in units of its noise floor."""
    left = rms(residual, plant, values)
    return max(left[name] / residual.noise_floors[name] for name in left)


def inflated_noise_floors(
    noise_floors: Mapping[str, float], residual: WeightedResidual, fitted: Fitted
) -> dict[str, float]:
    """Noise floors raised to the baseline's residual, so that model error counts as uncertainty."""
    left = rms(residual, fitted.plant, fitted.values)
    return {name: max(floor, left[name]) for name, floor in noise_floors.items()}


def rms(residual: WeightedResidual, plant: Plant, values: Mapping[str, float]) -> dict[str, float]:
    """RMS difference of each channel over all segments [its unit]."""
    return pooled(residual.raw(plant, values), residual.noise_floors)


def pooled(raw: Raw, names: Mapping[str, float]) -> dict[str, float]:
    """RMS of each channel over all segments that have it."""
    return {
        name: float(np.sqrt(np.mean(np.concatenate([r[name] for r in raw if name in r]) ** 2)))
        for name in names
        if any(name in r for r in raw)
    }


def relative(raw: Raw, segments: Sequence[Segment], name: str) -> float:
    """100 |difference| / |recorded| of a channel over all segments [%]."""
    there = [(r, p) for r, p in zip(raw, segments, strict=True) if name in r]
    difference = np.concatenate([r[name] for r, _ in there])
    recorded = np.concatenate([p.recording[name][p.mask] for _, p in there])
    size = float(np.linalg.norm(recorded))
    return 100.0 * float(np.linalg.norm(difference)) / size if size else 0.0
