"""Recordings of one command whose clocks jitter, or lost a sample, are put on one even grid.

A logger stamps each sample a little early or late. Runs that share a command then share no time,
and none would be a repeat of another; a sample of firmware would be read before its tick. Samples
go to the nearest place of a grid as they are; those few that were lost are interpolated. Where
stamps are off by much of an interval all values are interpolated. What a sensor counts in whole
steps stays in them. What fits no such grid stays as it was recorded.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.core.recording.recording import Recording
from hannes.core.recording.white_noise import quantum
from hannes.plants.protocol import Plant

STAMPED = 0.05  # of an interval, up to which stamps are off rather than samples
ROUNDED = 1e-6  # of an interval, by which the stamps of an even clock are off at most
FEWEST = 10  # samples that show an interval
RATE = 0.01  # by which the intervals of two such runs differ at most
OFF = 0.5  # of an interval, from its place of the grid, at most
PASSES = 3  # in which an interval and the places are found: two stamps may lie near each other
LOST = 3  # samples in a row that are interpolated at most
MOST_LOST = 0.05  # of all samples
EARLIER = 0.1  # of its duration, by which a run may begin before another
SHORTER = 0.02  # of the longest run, by which another may end earlier


@dataclass(frozen=True)
class Placed:
    """A recording's samples on an even grid: interval [s], place of each, shape (n,)."""

    interval: float
    places: np.ndarray


def on_one_grid(plant: Plant, entries: Sequence[Entry]) -> list[Entry]:
    """The entries, those of one condition and experiment on one grid where they need one."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for k, each in enumerate(entries):
        recording = each.recording
        kind = each.condition, each.unit, recording.experiment, tuple(recording.names)
        alike.setdefault(kind, []).append(k)
    made = list(entries)
    for some in alike.values():
        for k, recording in zip(some, _together(plant, [entries[k] for k in some]), strict=True):
            made[k] = replace(entries[k], recording=recording)
    return made


def _together(plant: Plant, entries: Sequence[Entry]) -> list[Recording]:
    runs = [each.recording for each in entries]
    apart = len({plant.same_run(each) for each in runs}) > 1
    if not apart and _is_even(runs[0].time):
        return runs
    placed = [_placed(each.time) for each in runs]
    if not apart and not all(_jitters(*pair) for pair in zip(runs, placed, strict=True)):
        return runs
    there = [each for each in placed if each is not None]
    if len(there) < len(runs) or not _alike(runs, there):
        return runs
    interval = float(np.median([each.interval for each in there]))
    if not _begin_together(runs, interval):
        return _with_one_command(plant, _interpolated(runs, interval)) or runs
    count = 1 + min(int(each.places[-1]) for each in there)
    time = _round(interval, count) * np.arange(count)
    made = [_resampled(*pair, time) for pair in zip(runs, there, strict=True)]
    return _with_one_command(plant, made) or runs


def _is_even(time: np.ndarray) -> bool:
    steps = np.diff(time)
    return bool(np.ptp(steps) <= ROUNDED * steps.min())


def _begin_together(runs: Sequence[Recording], interval: float) -> bool:
    """Whether runs begin within half an interval [s]: those that were aligned need not."""
    return float(np.ptp([each.time[0] for each in runs])) < OFF * interval


def _interpolated(runs: Sequence[Recording], interval: float) -> list[Recording]:
    """Runs of which each began at another time, at times that all of them have."""
    begin, end = max(each.time[0] for each in runs), min(each.time[-1] for each in runs)
    time = begin + interval * np.arange(1 + int((end - begin) / interval))
    return [replace(run, channels={"time": time, **_at(time, run.time, run)}) for run in runs]


def _at(time: np.ndarray, at: np.ndarray, run: Recording) -> dict[str, np.ndarray]:
    """Channels, recorded at some times, at other ones, shape (count,); in their steps."""
    names = [name for name in run.names if name != "time"]
    return {name: _in_steps(np.interp(time, at, run[name]), run[name]) for name in names}


def _round(interval: float, count: int) -> float:
    """The roundest interval [s] by which the last of so many samples hardly moves.

    Firmware's ticks are round, and a sample a little before one holds what the last one did.
    """
    near = STAMPED * interval / count
    found = (float(f"{interval:.{digits}g}") for digits in range(1, 6))
    return next((each for each in found if abs(each - interval) < near), interval)


def _jitters(run: Recording, placed: Placed | None) -> bool:
    """Whether stamps alone are off: samples that were taken at other times stay as they are."""
    return placed is not None and ROUNDED < _off(run, placed) / placed.interval < STAMPED


def _off(run: Recording, placed: Placed) -> float:
    """How far stamps lie from an even grid, RMS [s]."""
    return float(np.std(run.time - run.time[0] - placed.interval * placed.places))


def _placed(time: np.ndarray) -> Placed | None:
    """Places of the samples; None where they are on no even grid."""
    if time.size < FEWEST:
        return None
    since = time - time[0]
    steps = np.diff(since)
    usual = float(steps[steps < 1.5 * np.median(steps)].mean())
    some_lost = np.append(0.0, np.cumsum(np.rint(steps / usual)))
    found = (_fitted(since, places) for places in (np.arange(since.size, dtype=float), some_lost))
    return next((each for each in found if each is not None), None)


def _fitted(since: np.ndarray, places: np.ndarray) -> Placed | None:
    """The grid of such places; None where stamps [s] lie too far from it, or too many are lost."""
    for _ in range(PASSES):
        interval, first = np.polyfit(places, since, 1)
        places = np.rint((since - first) / interval)
    whole = np.diff(places)
    lost = float((whole - 1.0).sum())
    fits = whole.min() >= 1.0 and whole.max() <= 1 + LOST and lost <= MOST_LOST * since.size
    fits &= bool(np.abs(since - first - interval * places).max() < OFF * interval)
    return Placed(float(interval), (places - places[0]).astype(int)) if fits else None


def _alike(runs: Sequence[Recording], placed: Sequence[Placed]) -> bool:
    """Whether runs begin about together, have one rate, and are about as long."""
    intervals = np.array([each.interval for each in placed])
    last = np.array([each.places[-1] for each in placed])
    first = np.array([each.time[0] for each in runs])
    return bool(
        np.ptp(intervals) <= RATE * intervals.min()
        and np.ptp(last) <= SHORTER * last.max()
        and np.ptp(first) <= EARLIER * intervals.min() * last.min()
    )


def _resampled(run: Recording, placed: Placed, time: np.ndarray) -> Recording:
    """The run at the times of the grid, shape (count,)."""
    jitters = _off(run, placed) < STAMPED * placed.interval
    at = placed.places * (time[1] - time[0]) if jitters else run.time - run.time[0]
    return replace(run, channels={"time": run.time[0] + time, **_at(time, at, run)})


def _in_steps(values: np.ndarray, recorded: np.ndarray) -> np.ndarray:
    """Values between those recorded; where these stand in steps, in whole steps from the nearest.

    A step is known to few digits, so that it is not counted from far away.
    """
    if not (step := quantum(recorded)):
        return values
    known = np.unique(recorded)
    above = np.searchsorted(known, values).clip(1, known.size - 1)
    near = known[above - (values - known[above - 1] < known[above] - values)]
    return np.asarray(near + step * np.rint((values - near) / step))


def _with_one_command(plant: Plant, runs: Sequence[Recording]) -> list[Recording]:
    """The runs with the first's time and command; none where theirs differ by over two samples."""
    first = runs[0]
    wanted = {*plant.required, "reference"} - set(plant.judged)  # what is measured stays
    driven = [name for name in first.names if name in wanted]
    for name in driven:
        near = _reach(first[name])
        if any(np.any(np.abs(each[name] - first[name]) > near) for each in runs):
            return []
    own = {name: first[name] for name in ("time", *driven)}
    return [replace(each, channels={**each.channels, **own}) for each in runs]


def _reach(command: np.ndarray) -> np.ndarray:
    """By how much a command changes within two samples on either side, shape (n,)."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(command, 2, mode="edge"), 5)
    return np.ptp(around, axis=1) + 1e-12
