"""What a fault would do to a fit: a calibrated parameter off by so much, or so much residual.

Linearised inverse-dynamics least squares (the method published for EMPS: drive against
acceleration, speed, direction, position and a constant; other channels by their gain).
The columns of a channel's model are those of the sound run at the stamps that the spoiled log
states; what the fault adds to the channel moves the parameters by its projection on the columns,
and leaves the rest as residual. A parameter counts where its share of the channel stands well
above the noise floor, which is the RMS by which two repeats of the run differ. A start that is
late by up to 10 ms is allowed for, as the library does by default.

Of the result 1 is gross: a parameter off by 10 %, or a residual of five noise floors.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.intake.bases import Base, base
from benchmarks.intake.log import Log

FloatArray = NDArray[np.float64]

PARAMETER, RESIDUAL = 0.1, 5.0  # relative, noise floors
START = 10e-3  # s, that a run may start late by the library's own default
COUNTS = 3.0  # noise floors that a parameter's share must have to be one that is calibrated
DELAYS = np.arange(0.0, 0.3, 0.004)  # s, tried as the lag of motion behind its command
REFUSED = 10.0  # of a log that no fit can read as it is


@cache
def _columns(machine: str, number: int, name: str) -> tuple[FloatArray, FloatArray]:
    """Columns (n, k) of a channel's model times its parameters, and each one's RMS."""
    from scipy.signal import savgol_filter

    channels = base(machine, number).channels
    q, values = channels["position"], channels[name]
    speed, pull = (savgol_filter(q, 31, 3, deriv=d, delta=1e-3) for d in (1, 2))
    if name in ("position", "supply", "force", "sensor"):
        shares = values[:, None]
    else:
        direction = np.tanh(speed / (0.02 * np.abs(speed).max()))
        rows = np.column_stack((pull, speed, direction, q, np.ones(q.size)))
        found, *_ = np.linalg.lstsq(rows, values, rcond=None)
        shares = rows * found
    return shares, np.sqrt(np.mean(shares**2, axis=0))


def consequence(run: Base, log: Log) -> float:
    """Size of what is wrong with a log of a run; 0 for nothing, 1 from which it is gross."""
    time = log.time
    if time.size < 10 or not np.isfinite(time).all() or (np.diff(time) <= 0.0).any():
        return REFUSED
    if not np.all([np.isfinite(x).all() for x in log.columns.values()]):
        return REFUSED
    shift = _shift(run, log)
    names = [name for name in log.columns if name in run.noise_floors]
    return min(
        max((_of_channel(run, log, name, by) for name in names), default=0.0)
        for by in {shift, shift + _start(run, log, shift)}
    )


def _start(run: Base, log: Log, shift: float) -> float:
    """How much later the run seems to start, as far as a fit allows for it [s]."""
    at, time = log.time - shift, run.channels["time"]
    speed = np.interp(at, time, np.gradient(run.channels["position"], time))
    if "position" not in log.columns:
        return 0.0
    added = log.columns["position"] - np.interp(at, time, run.channels["position"])
    late = -float(speed @ added) / max(float(speed @ speed), 1e-300)
    return float(np.clip(late, -START, START))


def _shift(run: Base, log: Log) -> float:
    """How much later the log's clock is, by its own command: that drives the simulation."""
    if "reference" not in log.columns:
        return 0.0
    time, asked = run.channels["time"], run.channels["reference"]
    size = max(float(np.ptp(asked)), 1e-9)

    def apart(by: float) -> float:
        sound = np.interp(log.time - by, time, asked)
        return float(np.sqrt(np.mean((log.columns["reference"] - sound) ** 2))) / size

    own = float(log.time[0])
    least, by = min((apart(by), by) for by in (0.0, own, *DELAYS, *-DELAYS))
    return by if least < 0.01 and apart(0.0) > least else 0.0


def _of_channel(run: Base, log: Log, name: str, shift: float) -> float:
    at, time = log.time - shift, run.channels["time"]
    added = log.columns[name] - np.interp(at, time, run.channels[name])
    if name == "position" and "reference" in log.columns:
        asked = log.columns["reference"] - np.interp(at, time, run.channels["reference"])
        lag = 0.05 / max(float(np.median(np.diff(log.time))), 1e-9)
        late = np.roll(asked, min(round(lag), asked.size // 2))
        added -= late
    shares, sizes = _columns(run.machine, run.number, name)
    floor = run.noise_floors[name]
    rows = np.column_stack([np.interp(at, time, each) for each in shares.T])
    used = sizes > COUNTS * floor
    moved, *_ = np.linalg.lstsq(rows[:, used], added, rcond=None) if used.any() else (np.zeros(0),)
    rest = added - rows[:, used] @ moved
    residual = float(np.sqrt(np.mean(rest**2))) / floor
    most = float(np.abs(moved).max(initial=0.0))
    return max(most / PARAMETER, (residual - 1.0) / RESIDUAL)
