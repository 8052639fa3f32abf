"""Haptic channel: what is held and how hard, as the command of a tactor on the user's skin.

One causal signal at `rate`: contact gives a short pulse; then vibration whose frequency says rigid
or soft and whose amplitude says the force. A squeezing cuff gets the force alone. Doubt makes it
fainter: the lower end of the force's band counts, and without a class the frequency stays between.
Vibration of 50 to 250 Hz is what skin notices best (Bolanowski et al. 1988).
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

RECORD = struct.Struct("<dfff")  # board time [s], amplitude, frequency [Hz], squeeze
CHANNELS = {"vibration_amplitude": "1", "vibration_frequency": "Hz", "cuff_squeeze": "1"}


@dataclass(frozen=True)
class HapticSettings:
    """Rate [Hz]; pulse at a contact [s]; frequencies [Hz]; force that gives full amplitude [N]."""

    rate: float = 50.0
    pulse: float = 0.06
    soft_frequency: float = 80.0
    rigid_frequency: float = 230.0
    full_force: float = 100.0
    least: float = 0.1  # amplitude of anything that is held
    sure: float = 0.7  # probability from which a class is said

    @property
    def delay(self) -> float:
        """Longest time from a sample to the command that rests on it [s]."""
        return 1.0 / self.rate


class HapticSample(NamedTuple):
    """What is known at one tick; `force_low`: lower end of the force's band [N]."""

    period: float  # s since the last tick
    touched: bool
    rigid: float
    force_low: float


class HapticMemory(NamedTuple):
    """What is kept from tick to tick."""

    since_touch: float = -1.0  # s, below 0 while nothing is held
    since_sent: float = 1e9  # s since the last command


class HapticCommand(NamedTuple):
    """Amplitude (0 to 1) and frequency [Hz] of vibration, squeeze of a cuff (0 to 1)."""

    amplitude: float
    frequency: float
    squeeze: float


def haptic(
    settings: HapticSettings, memory: HapticMemory, sample: HapticSample
) -> tuple[HapticMemory, HapticCommand | None]:
    """Go on by one tick; returns the new memory, and a command where one is due."""
    held = memory.since_touch + sample.period if memory.since_touch >= 0.0 else 0.0
    held = held if sample.touched else -1.0
    waited = memory.since_sent + sample.period
    if waited < settings.delay * (1.0 - 1e-9):
        return HapticMemory(held, waited), None
    return HapticMemory(held, 0.0), _command(settings, held, sample)


def _command(settings: HapticSettings, held: float, sample: HapticSample) -> HapticCommand:
    if held < 0.0:
        return HapticCommand(0.0, 0.0, 0.0)
    share = min(max(sample.force_low / settings.full_force, 0.0), 1.0)
    amplitude = settings.least + (1.0 - settings.least) * share
    return HapticCommand(
        1.0 if held < settings.pulse else amplitude, _frequency(settings, sample.rigid), share
    )


def _frequency(settings: HapticSettings, rigid: float) -> float:
    if rigid >= settings.sure:
        return settings.rigid_frequency
    if rigid <= 1.0 - settings.sure:
        return settings.soft_frequency
    return 0.5 * (settings.soft_frequency + settings.rigid_frequency)


def line(command: HapticCommand) -> bytes:
    """The command as a line of text for a tactor's controller: `h AMPLITUDE FREQUENCY SQUEEZE`."""
    amplitude, frequency, squeeze = command
    return f"h {amplitude:.3f} {frequency:.0f} {squeeze:.3f}\n".encode()


def pack(time: float, command: HapticCommand) -> bytes:
    """The command in a raw log, with the board time [s] of the sample that it rests on."""
    return RECORD.pack(time, *command)


def unpack(data: bytes) -> tuple[float, ...]:
    """Board time [s], amplitude, frequency [Hz] and squeeze; empty where `data` is none of it."""
    return RECORD.unpack(data) if len(data) == RECORD.size else ()


def channels(
    commands: Sequence[tuple[float, ...]], board: np.ndarray
) -> dict[str, tuple[str, np.ndarray]]:
    """Unit and values at board times (n,) [s]: each command lasts until the next."""
    if not commands:
        return {}
    table = np.array(sorted(commands))
    place = np.searchsorted(table[:, 0], board + 1e-9, side="right") - 1
    return {
        name: (unit, np.where(place >= 0, table[np.maximum(place, 0), k + 1], 0.0))
        for k, (name, unit) in enumerate(CHANNELS.items())
    }
