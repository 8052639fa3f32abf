"""What goes wrong with a log's clock and with the order of its rows."""

from dataclasses import replace

import numpy as np

from benchmarks.intake.log import Log, kind
from hannes.core.recording.white_noise import quantum


def _together(log: Log, size: float) -> str:
    """A clock that is shifted together with the command changes nothing."""
    if "reference" in log.columns:
        return "command and motion share the clock"
    small = 3.0 * 1200.0**size * size < 0.14
    return _unknown(log) or ("the machine itself may lag so" if small else "")


def _unknown(log: Log) -> str:
    return "no command is known" if log.machine != "hand" and "reference" not in log.columns else ""


def _rate(log: Log, size: float) -> str:
    return "" if log.machine == "hand" else "no command to compare the clock with"


@kind("clock", "late-start", "ms before", restorable=True, hidden=_together)
def clock_of_another_start(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The logger's clock began hours, or parts of a second, before the command."""
    return log.changed(time=log.time + 3.0 * 1200.0**size * size)


def _lags(log: Log, size: float) -> str:
    """Lags that the machine itself may have."""
    longest = {"hand": 0.2, "axis": 0.1, "servo": 0.1}[log.machine]
    return "the machine itself may lag so" if 0.5 * size < longest - 0.06 else ""


@kind("late-start", "two clocks", restorable=True, hidden=_lags)
def command_of_another_clock(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The command was logged by another computer, whose clock is apart."""
    if "reference" not in log.columns:
        return None
    late = (0.5 if rng.random() < 0.5 else -0.5) * size
    time, asked = log.time, log.columns["reference"]
    return log.changed(reference=np.interp(time - late, time, asked))


@kind("unit", "milliseconds", restorable=True, graded=False)
def milliseconds_as_seconds(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Stamps in milliseconds were taken for seconds."""
    return log.changed(time=1e3 * log.time)


@kind("unit", "milliseconds", restorable=True, graded=False)
def seconds_as_milliseconds(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Stamps in seconds were taken for milliseconds."""
    return log.changed(time=1e-3 * log.time)


@kind("drift", "clock", restorable=True, hidden=_rate)
def clock_that_runs_fast(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """A nominal rate that is not the true one."""
    faster = 1.0 + 0.3 * size * (1.0 if rng.random() < 0.5 else -1.0)
    return log.changed(time=log.time * faster)


@kind("drift", "clock", restorable=True)
def clock_that_drifts(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """A clock whose rate changes during the run, against the count of samples."""
    share = np.linspace(0.0, 1.0, log.time.size)
    sign = 1.0 if rng.random() < 0.5 else -1.0
    return log.changed(time=log.time * (1.0 + 0.4 * sign * size * (1.0 - share)))


@kind("lost", "jump", restorable=False)
def rows_lost_under_a_counted_clock(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Some rows were lost, and the stamps were made by counting."""
    start = int(rng.uniform(0.2, 0.5) * log.time.size)
    lost = round(0.3 * size * log.time.size)
    kept = np.delete(np.arange(log.time.size), np.arange(start, start + lost))
    left = log.rows(kept).changed(time=log.time[: kept.size])
    return replace(left, reason=_rested(log, start, start + lost))


def _rested(log: Log, start: int, end: int) -> str:
    """Rows that are lost while all stands can be seen by the command alone."""
    asked = log.columns.get("reference")
    if log.machine == "hand" and asked is None:
        return ""
    watched = [log.columns["position"], *([] if asked is None else [asked])]
    steps = [np.ptp(x[max(start - 1, 0) : end + 1]) for x in watched]
    counts = [3.0 * quantum(x) + 1e-4 * np.ptp(x) for x in watched]
    still = all(step <= count for step, count in zip(steps, counts, strict=True))
    return "lost while all stood still: no command says for how long" if still else ""


@kind("order", "doubled", restorable=True, graded=False)
def doubled_stamps(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Two rows in a stamp, here and there."""
    count = max(log.time.size // 20, 2)
    places = 2 * rng.choice(log.time.size // 2 - 1, count, replace=False)
    time = log.time.copy()
    time[places + 1] = time[places]
    return log.changed(time=time)


@kind("order", "swapped", restorable=True, graded=False)
def swapped_rows(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Rows that came over a network in another order."""
    places = np.arange(log.time.size)
    for first in rng.choice(log.time.size // 2 - 1, max(log.time.size // 40, 1), replace=False):
        places[2 * first : 2 * first + 2] = places[2 * first : 2 * first + 2][::-1]
    return log.rows(places)


@kind("split", "restart", restorable=True, graded=False)
def two_runs_in_a_file(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The logger ran on, and its time began anew."""
    return log.rows(np.concatenate((np.arange(log.time.size), np.arange(log.time.size))))


@kind("coarse", "sampling", "order", restorable=True, graded=False)
def stamps_of_whole_hundredths(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Stamps were written with two digits only."""
    if np.median(np.diff(log.time)) > 4e-3:
        return None
    return log.changed(time=np.floor(100.0 * log.time + 1e-9) / 100.0)


@kind("late-start", "already moves", "away from", "before", hidden=lambda log, size: _unknown(log))
def logger_started_late(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The logger was started when the machine moved already."""
    moved = np.abs(log.columns["position"] - log.columns["position"][0])
    begun = int(np.argmax(moved > 0.02 * moved.max()))
    late = begun + round(size * 0.3 * log.time.size)
    if log.time.size - late < 40:
        return None
    return log.rows(slice(late, None)).changed(time=log.time[late:] - log.time[late])


@kind("held", "repeat", restorable=False)
def frames_held(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """A busy logger wrote the last frame again, several times, every now and then."""
    moving = np.flatnonzero(np.abs(np.gradient(log.columns["position"])) > 0.0)
    starts = rng.choice(moving, 8)
    long = 2 + round(size * 0.12 * log.time.size)
    rows = np.arange(log.time.size)
    for start in np.sort(starts):
        rows[start : start + long] = start
    measured = {n: x[rows] for n, x in log.columns.items() if n not in ("time", "reference")}
    return log.changed(**measured)


@kind("held", "renewed", restorable=False)
def all_renewed_slowly(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Values were read at a lower rate than they were written."""
    period = max(round(2 + size * 100.0 * 1e-3 / np.median(np.diff(log.time))), 2)
    rows = np.arange(log.time.size) // period * period
    measured = {n: x[rows] for n, x in log.columns.items() if n not in ("time", "reference")}
    return log.changed(**measured)


@kind("held", "renewed", restorable=False)
def one_channel_renewed_slowly(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The drive's column was renewed less often than the rest."""
    period = max(round(2 + size * 100.0 * 1e-3 / np.median(np.diff(log.time))), 2)
    rows = np.arange(log.time.size) // period * period
    return log.changed(**{log.drive: log.columns[log.drive][rows]})
