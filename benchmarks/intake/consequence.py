"""What a fault would do to a fit: a calibrated parameter off by so much, or so much residual.

Linearised inverse-dynamics least squares (the method published for EMPS: drive against
acceleration, speed, direction, position and a constant; other channels by their gain).
The columns of a channel's model are those of the sound run at the stamps that the spoiled log
states; of an axis or a servo with a recorded command they are those of the run that it makes under
the command as the spoiled log has it. What the fault adds to the channel moves the parameters by
its projection on the columns, and leaves the rest as residual. A parameter counts where its share
of the channel stands well above the noise floor, which is the RMS by which repeats of the run
scatter, and where repeats agree on it within 10 %. A start that is late by up to 10 ms is allowed
for, as the library does by default.

Of the result 1 is gross: a parameter off by 10 %, or a residual of five noise floors.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.intake.bases import Base, base, driven
from benchmarks.intake.log import Log

FloatArray = NDArray[np.float64]

PARAMETER, RESIDUAL = 0.1, 5.0  # relative, noise floors
START = 10e-3  # s, that a run may start late by the library's own default
COUNTS = 3.0  # noise floors that a parameter's share must have to be one that is calibrated
STEP = 4e-3  # s, between lags that are tried
FEW = 80  # samples by which they are tried
SAME, ALIKE = 1e-3, 1e-2  # of a command's range, by which it is the same, or the same but later
SHORT, LONG = 10.0, 3.0  # times shorter or longer than the run: no clock of it
REFUSED = 10.0  # of a log that no fit can read as it is
FEWEST = 10  # samples
BEGINS = 0.2  # s, at the start of a log that is simulated, over which the unknown start matters
PERIOD = 1e-3  # s, of the truth


@cache
def _columns(machine: str, number: int, name: str) -> tuple[FloatArray, FloatArray]:
    """Columns (n, k) of a channel's model times its parameters, and each one's RMS."""
    return _shares(base(machine, number).channels, name)


@cache
def _calibrated(machine: str, number: int, name: str) -> NDArray[np.bool_]:
    """Which parameters repeats agree on to better than what counts as gross, (k,)."""
    run = base(machine, number)
    shares, sizes = _columns(machine, number, name)
    used = sizes > COUNTS * run.noise_floors[name]
    for _ in range(used.size):
        if not used.any():
            break
        apart = np.column_stack([each[name] - run.channels[name] for each in run.repeats])
        moved, *_ = np.linalg.lstsq(shares[:, used], apart, rcond=None)
        spread = np.sqrt(np.mean(moved**2, axis=1) / 2.0)
        if spread.max() < PARAMETER:
            break
        used[np.flatnonzero(used)[np.argmax(spread)]] = False
    return used


def _shares(channels: Mapping[str, FloatArray], name: str) -> tuple[FloatArray, FloatArray]:
    from scipy.signal import savgol_filter

    q, values = channels["position"], channels[name]
    if name in ("position", "supply", "force", "sensor"):
        shares = values[:, None]
    else:
        speed, pull = (
            savgol_filter(q, 31, 3, deriv=d, delta=PERIOD, mode="nearest") for d in (1, 2)
        )
        direction = np.tanh(speed / max(0.02 * float(np.abs(speed).max()), 1e-300))
        rows = np.column_stack((pull, speed, direction, q, np.ones(q.size)))
        found, *_ = np.linalg.lstsq(rows, values, rcond=None)
        shares = rows * found
    return shares, np.sqrt(np.mean(shares**2, axis=0))


def consequence(run: Base, log: Log) -> float:
    """Size of what is wrong with a log of a run; 0 for nothing, 1 from which it is gross."""
    whole = np.all([np.isfinite(x) for x in log.columns.values()], axis=0)
    log = log if whole.all() else log.rows(whole)  # converting leaves out what lacks a value
    time = log.time
    if time.size < FEWEST or not np.isfinite(time).all() or (np.diff(time) <= 0.0).any():
        return REFUSED
    ratio = float(time[-1] - time[0]) / float(run.channels["time"][-1])
    if not 1.0 / SHORT < ratio < LONG:
        return REFUSED
    found = _consequence(run, log)
    if run.machine == "servo" and "reference" not in log.columns:
        return min(found, _consequence(run, _mirrored(log)))
    return found


def _mirrored(log: Log) -> Log:
    """The other way round, which is the same machine: without a command no sign is right."""
    names = [each for each in ("position", log.drive) if each in log.columns]
    return log.changed(**{name: -log.columns[name] for name in names})


def _consequence(run: Base, log: Log) -> float:
    answers = bool(run.values) and "reference" in log.columns
    if answers:
        run = _answering(run, log)
        log = log.rows(log.time >= log.time[0] + BEGINS)
        if log.time.size < FEWEST:
            return 0.0
    shift = 0.0 if answers else _shift(run, log)
    names = [name for name in log.columns if name in run.noise_floors]
    return min(
        max((_of_channel(run, log, name, by, answers) for name in names), default=0.0)
        for by in {shift, shift + _start(run, log, shift)}
    )


def _answering(run: Base, log: Log) -> Base:
    """The run as this machine would make it under the command that the log has, on its clock.

    That is what a fit simulates: what shifts or leaps together with its command does no harm.
    """
    clock = np.arange(round(float(log.time[-1] - log.time[0]) / PERIOD) + 1) * PERIOD
    asked = np.interp(clock, log.time - log.time[0], log.columns["reference"])
    found = driven(run.machine, run.values, asked)
    return replace(run, channels={**found, "time": clock + log.time[0]})


def _start(run: Base, log: Log, shift: float) -> float:
    """How much later the run seems to start, as far as a fit allows for it [s]."""
    at, time = log.time - shift, run.channels["time"]
    if "position" not in log.columns:
        return 0.0
    speed = np.interp(at, time, np.gradient(run.channels["position"], time))
    added = log.columns["position"] - np.interp(at, time, run.channels["position"])
    late = -float(speed @ added) / max(float(speed @ speed), 1e-300)
    return float(np.clip(late, -START, START))


def _shift(run: Base, log: Log) -> float:
    """How much later the log's clock is, by its own command: that drives the simulation."""
    if "reference" not in log.columns:
        return 0.0
    time, asked = run.channels["time"], run.channels["reference"]
    size = max(float(np.ptp(asked)), 1e-9)
    few = slice(None, None, max(log.time.size // FEW, 1))
    stamps, given = log.time[few], log.columns["reference"][few]

    def apart(by: float) -> float:
        return float(np.sqrt(np.mean((given - np.interp(stamps - by, time, asked)) ** 2))) / size

    if apart(0.0) < SAME:
        return 0.0
    longest = float(time[-1])
    delays = (*np.arange(0.0, longest, STEP), *np.arange(-STEP, -longest, -STEP))
    least, by = min((apart(by), by) for by in (0.0, float(log.time[0]), *delays))
    return float(by) if least < ALIKE and apart(0.0) > least else 0.0


def _of_channel(run: Base, log: Log, name: str, shift: float, answers: bool) -> float:
    at, time = log.time - shift, run.channels["time"]
    added = log.columns[name] - np.interp(at, time, run.channels[name])
    if name == "position" and "reference" in log.columns and not answers:
        asked = log.columns["reference"] - np.interp(at, time, run.channels["reference"])
        lag = 0.05 / max(float(np.median(np.diff(log.time))), 1e-9)
        late = np.roll(asked, min(round(lag), asked.size // 2))
        added -= late
    known = run.machine, run.number, name
    shares, sizes = _shares(run.channels, name) if answers else _columns(*known)
    floor = run.noise_floors[name]
    rows = np.column_stack([np.interp(at, time, each) for each in shares.T])
    used = (sizes > COUNTS * floor) & _calibrated(*known)
    moved, *_ = np.linalg.lstsq(rows[:, used], added, rcond=None) if used.any() else (np.zeros(0),)
    rest = added - rows[:, used] @ moved
    residual = float(np.sqrt(np.mean(rest**2))) / floor
    most = float(np.abs(moved).max(initial=0.0))
    return max(most / PARAMETER, (residual - 1.0) / RESIDUAL)
