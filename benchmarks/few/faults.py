"""Faults as loggers make them, put into the recordings of a small campaign."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hannes.core.recording.recording import Recording

Recordings = Sequence[Recording]


def _with(recording: Recording, **channels: np.ndarray) -> Recording:
    return replace(recording, channels={**recording.channels, **channels})


def magnitude(recording: Recording, k: int) -> Recording:
    """The current's sign is lost."""
    return _with(recording, current=np.abs(recording["current"]))


def supply_current(recording: Recording, k: int) -> Recording:
    """The current of the supply stands for that of the motor."""
    return _with(recording, current=recording["current"] * np.abs(recording["duty"]))


def clipped(recording: Recording, k: int) -> Recording:
    """The current's sensor ends at 60 % of its peak."""
    most = 0.6 * float(np.abs(recording["current"]).max())
    return _with(recording, current=np.clip(recording["current"], -most, most))


def gain(recording: Recording, k: int) -> Recording:
    """The current's sensor reads 15 % too much."""
    return _with(recording, current=1.15 * recording["current"])


def late_command(recording: Recording, k: int) -> Recording:
    """The command's clock is 60 ms off that of the sensors."""
    since = recording.time - recording.time[0]
    return _with(recording, reference=np.interp(since - 0.06, since, recording["reference"]))


def slow_clock(recording: Recording, k: int) -> Recording:
    """The clock runs 8 % fast against the machine."""
    start = recording.time[0]
    return _with(recording, time=start + 1.08 * (recording.time - start))


def encoder_zero(recording: Recording, k: int) -> Recording:
    """The encoder was not zeroed."""
    return _with(recording, position=recording["position"] + 0.35)


def frozen(recording: Recording, k: int) -> Recording:
    """The position stands still for a fifth of the run."""
    position, size = recording["position"].copy(), len(recording)
    position[size // 4 : size // 4 + size // 5] = position[size // 4]
    return _with(recording, position=position)


def held(recording: Recording, k: int) -> Recording:
    """The current is renewed every 12 ms."""
    at = (np.arange(len(recording)) // 12) * 12
    return _with(recording, current=recording["current"][at])


def held_frames(recording: Recording, k: int) -> Recording:
    """All channels stand still for 25 ms, four times a run."""
    at = np.arange(len(recording))
    for start in np.linspace(0.15, 0.8, 4) * at.size:
        at[int(start) : int(start) + 25] = int(start)
    channels = {n: each[at] for n, each in recording.channels.items() if n != "time"}
    return _with(recording, **channels)


def reversed_sign(recording: Recording, k: int) -> Recording:
    """The current counts the other way."""
    return _with(recording, current=-recording["current"])


def off(recording: Recording, k: int) -> Recording:
    """The drive's log ends at 70 % of the run: current and duty are zero from there."""
    there = np.arange(len(recording)) < 0.7 * len(recording)
    return _with(recording, current=recording["current"] * there, duty=recording["duty"] * there)


def weak_battery(recording: Recording, k: int) -> Recording:
    """The supply reads 0.4 V less from run to run."""
    return _with(recording, supply=recording["supply"] - 0.4 * k)


def wrong_unit(recording: Recording, k: int) -> Recording:
    """The position is in turns of 360, as a degree-minded logger has it, divided by 60."""
    return _with(recording, position=recording["position"] * 180.0 / np.pi / 60.0)


KINDS: dict[str, Callable[[Recording, int], Recording]] = {
    each.__name__: each
    for each in (
        magnitude, supply_current, clipped, gain, late_command, slow_clock, encoder_zero, frozen,
        held, held_frames, reversed_sign, off, weak_battery, wrong_unit,
    )
}  # fmt: skip
