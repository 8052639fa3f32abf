"""Right readings under a wrong name, sign, unit or run."""

import numpy as np

from benchmarks.intake.log import Log, kind


def _one_way(log: Log, size: float) -> str:
    return "" if "reference" in log.columns or log.machine == "hand" else "no command is known"


def _pushed_one_way(log: Log, size: float) -> str:
    """Where the machine is only ever driven one way, or helped back, the other sign may be."""
    return ""


@kind("sign", "reversed", restorable=True, graded=False, hidden=lambda log, size: (
    "all signs of motion are a convention" if "reference" not in log.columns
    and log.machine != "hand" and log.drive not in log.columns else ""))  # fmt: skip
def position_reversed(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The encoder counts the other way."""
    return log.changed(position=-log.columns["position"])


@kind("sign", "reversed", restorable=True, graded=False)
def drive_reversed(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The wires of the current sensor were swapped."""
    return log.changed(**{log.drive: -log.columns[log.drive]})


@kind("unit", "deg", "times as far", restorable=True, graded=False, hidden=_one_way)
def degrees_as_radians(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Degrees were taken for radians, or millimetres for metres."""
    factor = 1e3 if log.machine == "axis" else 180.0 / np.pi
    return log.changed(position=factor * log.columns["position"])


@kind("unit", "thousand", restorable=True, graded=False, hidden=lambda log, size: (
    "no plausible size of a current is known" if log.machine == "servo" else ""))  # fmt: skip
def milliamperes_as_amperes(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Thousandths were taken for whole units."""
    return log.changed(**{log.drive: 1e3 * log.columns[log.drive]})


@kind("unit", "percent", restorable=True, graded=False)
def percent_as_share(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The duty cycle was logged in percent."""
    if "duty" not in log.columns:
        return None
    return log.changed(duty=100.0 * log.columns["duty"])


@kind("unit", "side", restorable=True, graded=False)
def angle_of_the_motor(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The angle before the reducer was taken for that behind it."""
    if log.machine != "hand":
        return None
    return log.changed(position=19.0 * log.columns["position"])


@kind("magnitude", restorable=False, graded=False)
def magnitude_of_drive(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The current was logged without its sign."""
    values = log.columns[log.drive]
    if values.min() > -0.1 * values.max():
        return None
    return log.changed(**{log.drive: np.abs(values)})


@kind("magnitude", "supply", restorable=True, graded=False)
def current_of_the_supply(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The current was measured where it leaves the supply."""
    if "duty" not in log.columns:
        return None
    drawn = log.columns["duty"] * log.columns["current"]
    return log.changed(current=np.round(drawn / 1e-4) * 1e-4)


def _same_command(log: Log, size: float) -> str:
    same = "the other run had the same command: it is one of this experiment"
    return _one_way(log, size) or (same if log.same_command else "")


@kind("unlike", "column", "does not follow", restorable=False, graded=False, hidden=_same_command)
def motion_of_another_run(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Motion and command are of two runs."""
    time, names = log.time, ("position", log.drive)
    other = {n: np.interp(time, log.other["time"], log.other[n]) for n in names}
    return log.changed(**other)


@kind("unlike", "column", "does not follow", restorable=False, graded=False, hidden=lambda log,
      size: "no command is known" if _one_way(log, size) else "")  # fmt: skip
def column_of_another_sensor(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """A thermometer's column was mapped as the position."""
    drift = np.cumsum(rng.standard_normal(log.time.size))
    values = log.columns["position"]
    return log.changed(position=float(np.ptp(values)) * drift / float(np.ptp(drift)))


@kind("swapped", "before", "sign", "unlike", restorable=True, graded=False)
def command_and_motion_swapped(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The columns of command and motion were taken for each other."""
    if "reference" not in log.columns:
        return None
    return log.changed(position=log.columns["reference"], reference=log.columns["position"])


@kind("zero", "away from", "late-start", restorable=True, hidden=lambda log, size: (
    "a zero is a convention" if "reference" not in log.columns else ""))  # fmt: skip
def zero_of_position(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The encoder was not set to zero."""
    by = rng.choice([-1.0, 1.0]) * size * float(np.ptp(log.columns["position"]))
    return log.changed(position=log.columns["position"] + by)


@kind("gain", "unit", hidden=lambda log, size: "a gain within what the plant allows: its prior")
def gain_of_drive(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The sensor of the drive has another gain than its data sheet says."""
    return log.changed(**{log.drive: (1.0 + 0.6 * size) * log.columns[log.drive]})
