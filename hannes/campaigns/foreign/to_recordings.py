"""Columns of a foreign file into runs: channels in the plant's units on one clock."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.binary_columns import Arrays
from hannes.campaigns.foreign.long_table import Wide
from hannes.campaigns.foreign.mapping import ChannelRule, ColumnMap, FurtherFile, TimeRule
from hannes.campaigns.foreign.raw_values import (
    disorder,
    forward,
    in_order,
    motor_current,
    readings,
    restarts,
    signed,
    unwrapped,
)
from hannes.campaigns.foreign.resample import resampled
from hannes.campaigns.foreign.side_by_side import SideBySide, is_starred
from hannes.campaigns.foreign.sources import Source, open_source
from hannes.campaigns.foreign.stacked import Stacked
from hannes.campaigns.foreign.text_columns import Delimited
from hannes.campaigns.held_rows import MOTIONS, held_rows
from hannes.core.errors import BadInput

FloatArray = NDArray[np.float64]

ROUNDING = 1e-9  # s, of times that a mapping states


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
    disordered: int = 0


def read_runs(path: Path, mapping: ColumnMap) -> list[Run]:
    """Return the runs of a file, at least one; BadInput names the file and the line."""
    source = _opened(path, mapping)
    raw = _raw(path, source, mapping, "")
    time = times_of(source, mapping.time, next(iter(raw.values())).size)
    if time.size != next(iter(raw.values())).size:
        lengths = {name: values.size for name, values in raw.items()}
        raise BadInput(f"{path}: time has {time.size} samples, the channels {lengths}")
    for name, further in mapping.files.items():
        raw |= _beside(path, mapping, name, further, time)
    parts = _parts(source, mapping, time)
    long = [rows for rows in parts if rows.size > 1] or parts
    runs = [_run(source, mapping, time, raw, rows) for rows in long]
    alone = len(parts) - len(long)  # rows between two splits, which are no run
    return [replace(runs[0], dropped=runs[0].dropped + alone), *runs[1:]]


def _opened(path: Path, mapping: ColumnMap) -> Source:
    """The first file of a run, as a table with a row a sample."""
    source = open_source(path, mapping.text, mapping.missing)
    if mapping.long is not None:
        if not isinstance(source, Arrays | Delimited):
            raise BadInput(f"{path}: has no rows of names and values; leave long out")
        return Wide(source, mapping.long, mapping.time, mapping.split)
    rules = [rule for rule in mapping.channels.values() if not rule.source]
    columns = [rule.column for rule in rules if rule.column is not None]
    if isinstance(source, Arrays) and any(is_starred(source, each) for each in columns):
        if mapping.split is not None or mapping.split_at:
            raise BadInput(f"{path}: a column with * makes a run each: leave split, split_at out")
        clock = [mapping.time.column] if mapping.time.column is not None else []
        return SideBySide(source, [*columns, *clock])
    if mapping.split_at != "stacked":
        return source
    if not isinstance(source, Arrays):
        raise BadInput(f'{path}: split_at = "stacked" is of arrays with two axes; this has none')
    return Stacked(source, columns, mapping.time.column)


def _raw(path: Path, source: Source, mapping: ColumnMap, which: str) -> dict[str, FloatArray]:
    """Channels that one file has, in their own units, put right; all of one length."""
    rules = {
        name: rule
        for name, rule in mapping.channels.items()
        if rule.column is not None and rule.source == which
    }
    if not rules:
        raise BadInput(f"{path}: no channel is mapped from this file")
    raw = {name: _put_right(source, rule) for name, rule in rules.items()}
    lengths = {name: values.size for name, values in raw.items()}
    if len(set(lengths.values())) > 1:
        shown = ", ".join(f"{name} {size}" for name, size in lengths.items())
        raise BadInput(f"{path}: channels of unequal length ({shown}): map those of one logger")
    if not all(lengths.values()):
        raise BadInput(f"{path}: the mapped columns hold no rows")
    return raw


def _put_right(source: Source, rule: ChannelRule) -> FloatArray:
    """Raw numbers of a channel: signed, unwrapped, in the channel's unit."""
    assert rule.column is not None
    values = source.numbers(rule.column)
    if rule.bits:
        values = signed(values, rule.bits)
    if rule.turn:
        turn = rule.turn
        values = _each_run(source, values, lambda own: unwrapped(own, turn))
    return rule.factor * values + rule.offset


def times_of(source: Source, rule: TimeRule, count: int) -> FloatArray:
    """Times of all rows [s], shape (n,); from zero where there is a sampling rate alone."""
    if rule.column is None:
        return np.arange(count) / rule.sampling
    if rule.iso:
        return source.stamps(rule.column, rule.pattern)
    ticks = source.numbers(rule.column)
    if rule.turn:
        ticks = _each_run(source, ticks, lambda own: forward(own, rule.turn))
    return rule.factor * ticks


def _each_run(
    source: Source, values: FloatArray, put_right: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """A counter put right, for each run by itself where runs do not follow each other in time."""
    if not isinstance(source, Stacked | SideBySide):
        return put_right(values)
    return np.concatenate([put_right(each) for each in np.split(values, source.breaks(""))])


def _beside(
    path: Path, mapping: ColumnMap, name: str, further: FurtherFile, time: FloatArray
) -> dict[str, FloatArray]:
    """Channels of a further file at the times of the first: the last value known there."""
    if further.replace not in path.name:
        raise BadInput(f'{path}: files.{name}: its name has no "{further.replace}" to replace')
    other = path.with_name(path.name.replace(further.replace, further.by))
    source = open_source(other, mapping.text, mapping.missing)
    raw = _raw(other, source, mapping, name)
    own = times_of(source, further.time, next(iter(raw.values())).size)
    known = np.isfinite(own)
    if not (known.any() and np.isfinite(time).any()):
        raise BadInput(f"{path if known.any() else other}: its clock has no known time")
    own = own + further.time.offset
    if further.time.from_zero and not further.time.iso:  # both begin at once
        own += np.nanmin(time) - np.nanmin(own)
    _require_overlap(path, other, name, time, own)
    order = np.argsort(own[known], kind="stable")
    place = np.searchsorted(own[known][order], time, side="right") - 1
    return {
        channel: np.where(place >= 0, values[known][order][np.maximum(place, 0)], np.nan)
        for channel, values in raw.items()
    }


def _require_overlap(path: Path, other: Path, name: str, time: FloatArray, own: FloatArray) -> None:
    """Refuse two files whose clocks have no time in common."""
    (first, last), (begin, end) = ((np.nanmin(each), np.nanmax(each)) for each in (time, own))
    if begin <= last and first <= end:
        return
    key = f"files.{name}.time"
    mend = f'{key}.offset = "{first - begin:.12g} s"'
    raise BadInput(
        f"{other}: its clock runs from {begin:.12g} to {end:.12g} s, that of {path.name} from "
        f"{first:.12g} to {last:.12g} s: they never meet; set {mend}, or {key}.from_zero = true "
        "where both began at once",
        (mend,),
    )


def _parts(source: Source, mapping: ColumnMap, time: FloatArray) -> list[NDArray[np.intp]]:
    """Rows of each run: between changes of the column `split`, or where `split_at` says."""
    rows = np.arange(time.size)
    if isinstance(source, SideBySide):
        return np.split(rows, source.breaks(""))
    if mapping.split is not None:
        label = source.labels(mapping.split)
        return np.split(rows, 1 + np.flatnonzero(np.diff(label) != 0.0))
    if mapping.split_at == "restart":
        return np.split(rows, restarts(time))
    return np.split(rows, source.breaks(mapping.split_at)) if mapping.split_at else [rows]


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
        values = _values(mapping, name, raw, rows)
        channels[name] = _filled(times, values, how)
        filled[name] = int(np.count_nonzero(np.isfinite(channels[name]) & ~np.isfinite(values)))
        known &= np.isfinite(channels[name])
    if not rule.repeats:
        measured = [name for name in channels if name not in mapping.commands]
        units = [mapping.plant.channels[name] for name in measured]
        smooth = [each in MOTIONS for each in units]
        known[known] = ~held_rows([channels[name][known] for name in measured], smooth)
    kept = rows[known]
    if kept.size < 2:
        raise BadInput(f"{source.place(int(rows[0]))}: fewer than two complete rows follow")
    all_known = bool(known.all())  # of a long log no second copy is made
    found = {name: values if all_known else values[known] for name, values in channels.items()}
    ordered, found, kept = in_order(times[known], found, kept, rule.order)
    _require_increasing(source, ordered, kept)
    counts = {name: count for name, count in filled.items() if count}
    dropped = rows.size - int(np.count_nonzero(known))
    put_right = int(np.count_nonzero(known)) - kept.size
    return _clocked(Run(ordered, found, kept, dropped, counts, put_right), rule)


def _values(
    mapping: ColumnMap, name: str, raw: Mapping[str, FloatArray], rows: NDArray[np.intp]
) -> FloatArray:
    """One channel of one run: of a column, of supply current and duty, or a constant."""
    how = mapping.channels[name]
    if how.column is None:
        return np.full(rows.size, how.constant)
    values = raw[name] if rows.size == raw[name].size else raw[name][rows]
    if how.renewed:
        values = readings(values, how.renewed)
    return motor_current(values, raw["duty"][rows]) if how.supply else values


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
        what, mend = disorder(times)
        raise BadInput(
            f"{source.place(int(rows[first + 1]))}: time does not increase, {times[first]:.9g} s "
            f"is followed by {times[first + 1]:.9g} s ({stalled.size} such rows): {what}: {mend}",
            (mend,),
        )


def _clocked(run: Run, rule: TimeRule) -> Run:
    """Apply start, offset and resampling."""
    start = run.time[0] if rule.from_zero else 0.0
    run = _without(replace(run, time=run.time - start + rule.offset), rule)
    if not rule.resample:
        return run
    times, channels = resampled(run.time, run.channels, rule.resample)
    return replace(run, time=times, channels=channels)


def _without(run: Run, rule: TimeRule) -> Run:
    """Leave out the stretches that the mapping cuts."""
    if not rule.cut:
        return run
    bad = np.zeros(run.time.size, np.bool_)
    for start, end in rule.cut:
        bad |= (run.time >= start - ROUNDING) & (run.time <= end + ROUNDING)
    if np.count_nonzero(~bad) < 2:
        raise BadInput("time.cut leaves fewer than two rows")
    channels = {name: x[~bad] for name, x in run.channels.items()}
    return replace(run, time=run.time[~bad], channels=channels, rows=run.rows[~bad],
                   dropped=run.dropped + int(np.count_nonzero(bad)))  # fmt: skip
