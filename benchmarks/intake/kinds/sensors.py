"""What goes wrong with one sensor."""

import numpy as np

from benchmarks.intake.log import Log, kind
from hannes.core.recording.white_noise import noise, quantum


@kind("dead", restorable=False, graded=False)
def dead_position(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The encoder's cable was off."""
    return log.changed(position=np.full(log.time.size, rng.choice([0.0, 0.37])))


@kind("dead", restorable=False, graded=False)
def dead_drive(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The current was never read."""
    return log.changed(**{log.drive: np.full(log.time.size, rng.choice([0.0, 0.37]))})


@kind("frozen", "held", "stays", restorable=False)
def frozen_drive(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The drive's sensor dropped out for a while and kept its last value."""
    start = int(rng.uniform(0.15, 0.6) * log.time.size)
    values = log.columns[log.drive].copy()
    values[start : start + max(round(0.5 * size * values.size), 1)] = values[start]
    return log.changed(**{log.drive: values})


@kind("frozen", "jump", "held", "stays", restorable=False)
def frozen_position(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The encoder dropped out for a while and kept its last value."""
    start = int(rng.uniform(0.15, 0.6) * log.time.size)
    values = log.columns["position"].copy()
    values[start : start + max(round(0.5 * size * values.size), 1)] = values[start]
    return log.changed(position=values)


@kind("saturated", "clips", "flat", restorable=False)
def clipped_drive(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The range of the drive's sensor was too small."""
    values = log.columns[log.drive]
    top = (1.0 - 0.8 * size) * float(np.abs(values).max())
    return log.changed(**{log.drive: np.clip(values, -top, top)})


@kind("jump", "outlier", restorable=False)
def spikes_of_position(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Single readings of the encoder that are far off."""
    places = rng.choice(log.time.size, 1 + log.time.size // 100, replace=False)
    off = rng.uniform(0.3, 1.0, places.size) * rng.choice([-1.0, 1.0], places.size)
    values = log.columns["position"].copy()
    values[places] += size * 3.0 * off * np.ptp(values)
    return log.changed(position=values)


@kind("jump", "outlier", restorable=False)
def spikes_of_drive(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """Single readings of the drive that are far off."""
    places = rng.choice(log.time.size, 1 + log.time.size // 100, replace=False)
    off = rng.uniform(0.3, 1.0, places.size) * rng.choice([-1.0, 1.0], places.size)
    values = log.columns[log.drive].copy()
    values[places] += size * 10.0 * off * np.ptp(values)
    return log.changed(**{log.drive: values})


@kind("jump", "lost count", restorable=False)
def lost_counts(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The encoder lost counts at once, and is off from then on."""
    start = int(rng.uniform(0.2, 0.7) * log.time.size)
    values = log.columns["position"].copy()
    values[start:] += rng.choice([-1.0, 1.0]) * size * np.ptp(values)
    return log.changed(position=values)


@kind("jump", "unwrap", "wraps", restorable=True, graded=False)
def counter_that_wraps(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The encoder's counter begins anew after a turn."""
    values = log.columns["position"]
    turn = rng.uniform(0.35, 0.7) * np.ptp(values)
    return log.changed(position=np.mod(values, turn))


@kind("signed", "sign", restorable=True, graded=False)
def integers_without_their_sign(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """16-bit values below zero were read as above 32767."""
    values = log.columns[log.drive]
    if values.min() > -0.02 * np.ptp(values):
        return None
    scale = 1e-3
    return log.changed(**{log.drive: scale * np.mod(np.round(values / scale), 2.0**16)})


@kind("missing", "-999", restorable=True, graded=False)
def code_for_missing_values(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """A number stands for no value."""
    places = rng.choice(log.time.size, max(log.time.size // 50, 3), replace=False)
    name = rng.choice(["position", log.drive])
    values = log.columns[name].copy()
    values[places] = rng.choice([-999.0, 9999.0, -1000.0])
    return log.changed(**{str(name): values})


@kind("coarse", restorable=False)
def coarse_drive(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """The drive was logged with too few digits."""
    values = log.columns[log.drive]
    step = 0.7 * size * float(np.abs(values).max()) + 1e-12
    return log.changed(**{log.drive: step * np.round(values / step)})


def _no_command(log: Log, size: float) -> str:
    known = log.machine == "hand" or "reference" in log.columns
    return "" if known else "no command is known: a pause looks the same"


@kind("off", "disabled", "switched", restorable=False, hidden=_no_command)
def drive_switched_off(log: Log, size: float, rng: np.random.Generator) -> Log | None:
    """A protection switched the drive off within the run, and on again."""
    names = [n for n in ("drive", "current", "duty") if n in log.columns]
    start = int(rng.uniform(0.15, 0.5) * log.time.size)
    end = min(start + round(0.4 * size * log.time.size), log.time.size - 1)
    if end - start < 2:
        return log
    q = log.columns["position"].copy()
    fastest = float(np.abs(np.diff(q)).max())
    q[start:end] = q[start]
    for k in range(end, q.size):  # it catches up with its command
        gap = log.columns["position"][k] - q[k - 1]
        if abs(gap) <= fastest:
            break
        q[k] = q[k - 1] + np.sign(gap) * fastest
    changed = {"position": q}
    for name in names:
        values = log.columns[name].copy()
        size, step = noise(values), quantum(values)
        off = size * rng.standard_normal(values.size)[start:end]
        values[start:end] = step * np.round(off / step) if step else off
        changed[name] = values
    return log.changed(**changed)
