"""How far simulation and recordings lie apart: in all, by channel and phase, and over time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.campaigns.segments import Segment
from hannes.core.by_value import ByValue
from hannes.identification.holdout.least_squares import Fitted, Misfit
from hannes.plants.protocol import Plant

WORST = 12  # places of the where-map that are kept
Raw = Sequence[Mapping[str, np.ndarray]]  # of each piece: channel -> simulated minus recorded


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


def gaps(misfit: Misfit, before: Fitted, after: Fitted) -> dict[str, dict[str, Any]]:
    """RMS of each channel as given, with the base refitted, with the effect; and the floor."""
    stages = {
        "as_given": misfit.raw(misfit.plant, {}),
        "before": misfit.raw(before.plant, before.values),
        "after": misfit.raw(after.plant, after.values),
    }
    return tabled(stages, misfit.pieces, misfit.plant.channels, misfit.floors)


def tabled(
    stages: Mapping[str, Raw],
    pieces: Sequence[Segment],
    units: Mapping[str, str],
    floors: Mapping[str, float],
) -> dict[str, dict[str, Any]]:
    """The same from what each stage leaves of every piece."""
    sizes = {key: pooled(raw, floors) for key, raw in stages.items()}
    return {
        name: {"unit": units[name]}
        | {key: sizes[key][name] for key in stages}
        | {"floor": floors[name]}
        | {f"{key}_percent": relative(raw, pieces, name) for key, raw in stages.items()}
        for name in sizes["before"]
    }


def undone(gap: Mapping[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """The same gaps where no effect is named: what comes after is what was before."""
    return {
        name: {**each, "after": each["before"], "after_percent": each["before_percent"]}
        for name, each in gap.items()
    }


def where(misfit: Misfit, fitted: Fitted) -> list[dict[str, Any]]:
    """Channel and phase of what a fit leaves, worst first."""
    raw = misfit.raw(fitted.plant, fitted.values)
    return placed(misfit.plant, misfit.pieces, raw, misfit.floors)


def placed(
    plant: Plant, pieces: Sequence[Segment], raw: Raw, floors: Mapping[str, float]
) -> list[dict[str, Any]]:
    """Channel and phase of simulated minus recorded, worst first."""
    places: dict[tuple[str, str], list[tuple[np.ndarray, np.ndarray, str]]] = {}
    for piece, channels in zip(pieces, raw, strict=True):
        time = piece.recording.time[piece.mask]
        for phase, mask in plant.phases(piece.recording).items():
            inside = mask[piece.mask]
            for name, values in channels.items():
                if inside.any():
                    found = (values[inside], time[inside], piece.entry.name)
                    places.setdefault((name, phase), []).append(found)
    rows = [_place(*key, parts, floors) for key, parts in places.items()]
    return sorted(rows, key=lambda row: -row["times_floor"])[:WORST]


def _place(
    name: str,
    phase: str,
    parts: Sequence[tuple[np.ndarray, np.ndarray, str]],
    floors: Mapping[str, float],
) -> dict[str, Any]:
    size = float(np.sqrt(np.mean(np.concatenate([part[0] for part in parts]) ** 2)))
    return {
        "channel": name,
        "phase": phase,
        "t0": float(min(part[1][0] for part in parts)),
        "t1": float(max(part[1][-1] for part in parts)),
        "rms": size,
        "times_floor": size / floors[name],
        "recordings": sorted({part[2] for part in parts}),
    }


def traces(
    plant: Plant, entry: Entry, before: Fitted, after: Fitted, floors: Mapping[str, float]
) -> Traces:
    """Simulate one recording as given, with the base refitted, with the effect."""
    recording = entry.recording
    runs = (
        plant.simulate({}, recording),
        before.plant.simulate(before.values, recording),
        after.plant.simulate(after.values, recording),
    )
    names = [name for name in floors if name in recording]
    measured = {name: recording[name] for name in names}
    simulated = ({name: run[name] for name in names} for run in runs)
    return Traces(entry, recording.time, plant.judged_part(recording), measured, *simulated)


def times_floor(misfit: Misfit, plant: Plant, values: Mapping[str, float]) -> float:
    """RMS of the worst channel in units of its floor."""
    left = rms(misfit, plant, values)
    return max(left[name] / misfit.floors[name] for name in left)


def inflated(floors: Mapping[str, float], misfit: Misfit, fitted: Fitted) -> dict[str, float]:
    """Floors raised to what the refitted base leaves, so that misfit counts as uncertainty."""
    left = rms(misfit, fitted.plant, fitted.values)
    return {name: max(floor, left[name]) for name, floor in floors.items()}


def rms(misfit: Misfit, plant: Plant, values: Mapping[str, float]) -> dict[str, float]:
    """RMS difference of each channel over all pieces [its unit]."""
    return pooled(misfit.raw(plant, values), misfit.floors)


def pooled(raw: Raw, names: Mapping[str, float]) -> dict[str, float]:
    """RMS of each channel over all pieces that have it."""
    return {
        name: float(np.sqrt(np.mean(np.concatenate([r[name] for r in raw if name in r]) ** 2)))
        for name in names
        if any(name in r for r in raw)
    }


def relative(raw: Raw, pieces: Sequence[Segment], name: str) -> float:
    """100 |difference| / |recorded| of a channel over all pieces [%]."""
    there = [(r, p) for r, p in zip(raw, pieces, strict=True) if name in r]
    miss = np.concatenate([r[name] for r, _ in there])
    recorded = np.concatenate([p.recording[name][p.mask] for _, p in there])
    size = float(np.linalg.norm(recorded))
    return 100.0 * float(np.linalg.norm(miss)) / size if size else 0.0
