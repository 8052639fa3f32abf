"""Kinds of fault by somebody who knew neither the checks nor the other kinds."""

import numpy as np

from benchmarks.intake.log import Log, kind


def _filled(values: np.ndarray) -> np.ndarray:
    """The values as floats, with empty cells bridged by straight lines."""
    values = np.array(values, dtype=float)
    there = np.isfinite(values)
    if there.all() or not there.any():
        return values
    rows = np.arange(len(values))
    return np.interp(rows, rows[there], values[there])


def _at_travel(position: np.ndarray, share: float) -> int:
    """The row by which this share of the whole travel is done (so it is amid a motion)."""
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(_filled(position))))])
    return int(np.searchsorted(travel, share * travel[-1]))


def _no_command(log: Log) -> bool:
    return log.machine != "hand" and "reference" not in log.columns


@kind("wrap", "overflow", "roll", "modulo", "jump", restorable=True, graded=True)
def counter_overflows(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The encoder's 16-bit counter was not zeroed near the middle.

    Its upper counts come out a whole counter range lower.
    """
    position = np.array(log.columns["position"], dtype=float)
    whole = np.nanmax(position) - np.nanmin(position)
    modulus = (1.1 + 0.4 * rng.random()) * whole
    if size <= 0 or whole == 0:
        return log.changed(position=position)
    over = position > np.nanmax(position) - 0.7 * size * whole
    return log.changed(position=np.where(over, position - modulus, position))


@kind("slip", "lost", "drift", "jump", "step", "offset", "shift", restorable=False, graded=True)
def encoder_hub_slips(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """A loose grub screw: the encoder's hub turns less than the shaft.

    It does so for a part of the travel, and stays off from there.
    """
    position = np.array(log.columns["position"], dtype=float)
    begin = rng.uniform(0.1, 0.35)
    start, stop = _at_travel(position, begin), _at_travel(position, begin + 0.15)
    filled = _filled(position)
    missed = np.diff(filled, prepend=filled[0])
    rows = np.arange(len(position))
    missed[(rows <= start) | (rows > stop)] = 0.0
    return log.changed(position=position - size * np.cumsum(missed))


@kind("missing", "lost", "dropped", "skip", "jump", "gap", restorable=False, graded=True)
def burst_lost_and_stamped_by_counter(
    log: Log, size: float, rng: np.random.Generator
) -> Log | None:
    """A full serial buffer dropped a burst of packets.

    The host stamped what came by row number times period.
    """
    time = log.columns["time"]
    middle = _at_travel(log.columns["position"], rng.uniform(0.2, 0.6))
    count = round(0.2 * size * len(time))
    start = min(max(middle - count // 2, 1), len(time) - count - 1)
    keep = np.ones(len(time), dtype=bool)
    keep[start : start + count] = False
    return log.rows(keep).changed(time=time[: int(keep.sum())].copy())


@kind(
    "sign",
    "magnitude",
    "absolute",
    "unsigned",
    "rectified",
    "negative",
    "one-sided",
    restorable=False,
    graded=False,
)
def amplifier_monitor_gives_magnitude(
    log: Log, size: float, rng: np.random.Generator
) -> Log | None:
    """The bridge's low-side shunt (or its PWM pin without DIR) was logged: no sign is left."""
    drive = np.array(log.columns[log.drive], dtype=float)
    if -np.nanmin(drive) < 0.2 * np.nanmax(np.abs(drive)) or np.nanmax(drive) < 0.2 * np.nanmax(
        np.abs(drive)
    ):
        return None
    return log.changed(**{log.drive: np.abs(drive)})


@kind(
    "another run",
    "other run",
    "two runs",
    "second run",
    "backward",
    "restart",
    "order",
    "not increasing",
    restorable=False,
    graded=True,
)
def ring_buffer_not_flushed(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The logger's buffer still held the end of the run before.

    Its rows, with their own stamps, lead the file.
    """
    if not log.other:
        return None
    length = len(log.other["time"])
    count = round(0.6 * size * length)
    joined = {}
    for name, values in log.columns.items():
        old = log.other.get(name)
        old = np.full(length, np.nan) if old is None else np.asarray(old, dtype=float)
        joined[name] = np.concatenate([old[length - count :], np.asarray(values, dtype=float)])
    return log.changed(**joined)


@kind("clock", "stamp", "time", "gap", "backward", restorable=True, graded=True)
def ntp_steps_the_clock(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Stamps by the wall clock, which the PC's time service set amid the run."""
    time = np.array(log.columns["time"], dtype=float)
    start = int(rng.uniform(0.3, 0.7) * len(time))
    way = 1.0 if rng.random() < 0.5 else -1.0
    time[start:] += way * 0.5 * size * (time[-1] - time[0])
    return log.changed(time=time)


@kind(
    "crosstalk",
    "cross-talk",
    "coupl",
    "ground",
    "pick-up",
    "pickup",
    "interference",
    "leak",
    restorable=False,
    graded=True,
)
def sensor_ground_carries_motor_current(
    log: Log, size: float, rng: np.random.Generator
) -> Log | None:
    """The position potentiometer shares its ground lead with the motor.

    So the drive's current shows in the position.
    """
    position = np.array(log.columns["position"], dtype=float)
    drive = _filled(log.columns[log.drive])
    way = 1.0 if rng.random() < 0.5 else -1.0
    most = np.nanmax(np.abs(drive))
    if not most > 0:
        return None
    span = np.nanmax(position) - np.nanmin(position)
    return log.changed(position=position + way * 0.2 * size * span * drive / most)


@kind(
    "drive",
    "trip",
    "disabled",
    "off",
    "stopped",
    "dead",
    "stuck",
    "held",
    "frozen",
    "not follow",
    "unpowered",
    restorable=False,
    graded=True,
    hidden=lambda log, size: (
        "no command: a tripped drive looks like a planned stop" if _no_command(log) else ""
    ),
)
def drive_stage_trips(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Over-temperature: the drive stage switched itself off amid the run.

    The logger and the command went on.
    """
    time = log.columns["time"]
    position = np.array(log.columns["position"], dtype=float)
    drive = np.array(log.columns[log.drive], dtype=float)
    noise_position, noise_drive = rng.standard_normal(len(time)), rng.standard_normal(len(time))
    share = rng.uniform(0.85, 1.0)
    # At 1 it trips after a tenth or so of the travel; at 0 when all the travel is done.
    start = _at_travel(position, 1.0 - 0.9 * share * size) if size > 0 else len(time)
    if start >= len(time) - 2:
        return log.changed(position=position)
    filled = _filled(position)
    back = max(start - 5, 0)
    speed = (filled[start] - filled[back]) / (time[start] - time[back]) if start > back else 0.0
    coast = 0.02
    after = time[start:] - time[start]
    # The sensors' own noise, from second differences, robustly.
    rough = [
        np.nanmedian(np.abs(np.diff(x, 2))) / (0.6745 * np.sqrt(6.0)) for x in (position, drive)
    ]
    position[start:] = (
        filled[start]
        + speed * coast * (1.0 - np.exp(-after / coast))
        + rough[0] * noise_position[start:]
    )
    drive[start:] = rough[1] * noise_drive[start:]
    new = {"position": position, log.drive: drive}
    if "duty" in log.columns:
        duty = np.array(log.columns["duty"], dtype=float)
        duty[start:] = 0.0
        new["duty"] = duty
    return log.changed(**new)


@kind("gain", "scale", "range", "factor", "unit", restorable=False, graded=True)
def probe_range_switched(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Somebody turned the range knob of the probe amid the run.

    From there the drive reads up to ten times too small or large.
    """
    drive = np.array(log.columns[log.drive], dtype=float)
    start = _at_travel(log.columns["position"], rng.uniform(0.3, 0.6))
    way = 1.0 if rng.random() < 0.5 else -1.0
    drive[start:] *= 10.0 ** (way * size)
    return log.changed(**{log.drive: drive})


@kind(
    "speed",
    "slow",
    "override",
    "command",
    "rate",
    "stretch",
    "reference",
    restorable=False,
    graded=True,
    hidden=lambda log, size: (
        "without a command a slower motion is simply another motion" if _no_command(log) else ""
    ),
)
def speed_override_left_down(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The override knob was not at 100 %.

    The machine ran the same path slower than the command that is on file.
    """
    time = np.array(log.columns["time"], dtype=float)
    pace = 1.0 - (0.5 + 0.1 * rng.random()) * size
    at = time[0] + pace * (time - time[0])
    return log.changed(
        **{
            name: np.interp(at, time, _filled(values))
            for name, values in log.columns.items()
            if name not in ("time", "reference", "supply")
        }
    )
