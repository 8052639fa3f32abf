"""Columns of a foreign file into runs: channels in the plant's units on one clock."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.mapping import ChannelRule, ColumnMap, TimeRule
from hannes.campaigns.foreign.resample import resampled
from hannes.campaigns.foreign.sources import Source, open_source
from hannes.core.errors import BadInput

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """One run of a file: times [s] and channels in the plant's units, each of shape (n,).

    rows: their rows in the file; dropped: rows left out because a value was missing; filled:
    channel -> number of values filled in.
    """

    time: FloatArray
    channels: Mapping[str, FloatArray]
    rows: NDArray[np.intp]
    dropped: int
    filled: Mapping[str, int]


def read_runs(path: Path, mapping: ColumnMap) -> list[Run]:
    """Return the runs of a file, at least one; BadInput names the file and the line."""
    source = open_source(path, mapping.text, mapping.missing)
    raw = {name: source.numbers(rule.column) for name, rule in mapping.channels.items()}
    lengths = {name: values.size for name, values in raw.items()}
    if len(set(lengths.values())) > 1:
        shown = ", ".join(f"{name} {size}" for name, size in lengths.items())
        raise BadInput(f"{path}: channels of unequal length ({shown}): map those of one logger")
    time = _times(source, mapping.time, next(iter(lengths.values())))
    if time.size != next(iter(lengths.values())):
        raise BadInput(f"{path}: time has {time.size} samples, the channels {lengths}")
    parts = _parts(source, mapping, time.size)
    return [_run(source, mapping, time, raw, rows) for rows in parts]


def _times(source: Source, rule: TimeRule, count: int) -> FloatArray:
    if rule.column is None:
        return np.arange(count) / rule.sampling
    if rule.iso:
        return source.stamps(rule.column)
    return rule.factor * source.numbers(rule.column)


def _parts(source: Source, mapping: ColumnMap, count: int) -> list[NDArray[np.intp]]:
    """Rows of each run: successive rows with one value in the column `split`."""
    rows = np.arange(count)
    if mapping.split is None:
        return [rows]
    label = source.numbers(mapping.split)
    return np.split(rows, 1 + np.flatnonzero(np.diff(label) != 0.0))


def _run(
    source: Source,
    mapping: ColumnMap,
    time: FloatArray,
    raw: Mapping[str, FloatArray],
    rows: NDArray[np.intp],
) -> Run:
    rule = mapping.time
    times = time[rows] - (time[rows[0]] if rule.column is None else 0.0)
    known = np.isfinite(times)
    channels, filled = {}, {}
    for name, how in mapping.channels.items():
        values = how.factor * raw[name][rows] + how.offset
        channels[name] = _filled(times, values, how)
        filled[name] = int(np.count_nonzero(np.isfinite(channels[name]) & ~np.isfinite(values)))
        known &= np.isfinite(channels[name])
    kept = rows[known]
    if kept.size < 2:
        raise BadInput(f"{source.place(int(rows[0]))}: fewer than two complete rows follow")
    _require_increasing(source, times[known], kept)
    run = Run(
        times[known],
        {name: values[known] for name, values in channels.items()},
        kept,
        rows.size - kept.size,
        {name: count for name, count in filled.items() if count},
    )
    return _clocked(run, rule)


def _filled(times: FloatArray, values: FloatArray, rule: ChannelRule) -> FloatArray:
    """Values with inner gaps filled as the rule says; NaN where nothing is known."""
    there = np.flatnonzero(np.isfinite(values) & np.isfinite(times))
    if rule.fill == "drop" or there.size < 2:
        return values
    if rule.fill == "linear":
        between = np.interp(times, times[there], values[there], left=np.nan, right=np.nan)
        return np.where(np.isfinite(values), values, between)
    last = np.searchsorted(there, np.arange(values.size), side="right") - 1
    return np.where(last >= 0, values[there[np.maximum(last, 0)]], np.nan)


def _require_increasing(source: Source, times: FloatArray, rows: NDArray[np.intp]) -> None:
    stalled = np.flatnonzero(np.diff(times) <= 0.0)
    if stalled.size:
        first = int(stalled[0])
        raise BadInput(
            f"{source.place(int(rows[first + 1]))}: time does not increase, {times[first]:.9g} s "
            f"is followed by {times[first + 1]:.9g} s ({stalled.size} such rows); name the split "
            "column of several runs, or give time.sampling instead of a clock that is too coarse"
        )


def _clocked(run: Run, rule: TimeRule) -> Run:
    """Apply start, offset and resampling."""
    start = run.time[0] if rule.from_zero else 0.0
    times = run.time - start + rule.offset
    if not rule.resample:
        return replace(run, time=times)
    times, channels = resampled(times, run.channels, rule.resample)
    return replace(run, time=times, channels=channels)
