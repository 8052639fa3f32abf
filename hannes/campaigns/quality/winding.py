"""The measured current against what the supply can drive through the motor's winding.

Voltage = resistance x current + constant x speed: with the duty recorded it gives the current's
gain, without it a bound, for a motor that drives has no more than the supply over its resistance.
"""

from collections.abc import Iterator

import numpy as np

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault
from hannes.campaigns.quality.law import FEWEST, laws, speed_of
from hannes.campaigns.quality.subject import Subject, Winding, noise, running_median
from hannes.plants.protocol import Plant

NAMES = (
    "motor.resistance",
    "motor.torque_constant",
    "gear.ratio",
    "supply.voltage",
)
LEFT = 0.2  # of the current, that its law may leave
CONSTANT = 1.4  # factor by which the law's back EMF may be another than stated
WRONG = 3.0  # factor of the current that no machine as stated explains
ROUND = 0.15  # relative, about a power of ten that a mistake makes
MARGIN, VOLTAGE = 1.15, 1.05  # times the bound, and the stated voltage, that may be exceeded
FREE = 0.8  # of the voltage, that the back EMF has at most where the motion is in its unit
LONG, SHARE = 10, 0.02  # samples beyond the bound, and their share


def winding_of(plant: Plant) -> Winding | None:
    """A plant's winding, None where its parameters do not say."""
    if any(name not in plant.parameters for name in NAMES):
        return None
    resistance, constant, ratio, voltage = (float(plant.parameters[name]) for name in NAMES)
    known = min(resistance, constant, ratio, voltage) > 0.0
    return Winding(resistance, voltage, constant * ratio) if known else None


def inspect(subject: Subject) -> Iterator[Finding]:
    """At most one finding: a current too large or too small for its winding."""
    winding, moved = subject.winding, subject.of("current").drives
    if winding is None or "current" not in subject.recording or moved not in subject.recording:
        return
    if len(subject.recording) < FEWEST:
        return
    gain = gain_of(subject, winding)
    if gain is None:
        yield from _bounded(subject, winding, moved)
        return
    if max(gain, 1.0 / gain) > WRONG:
        volts = "the supply" if "supply" in subject.recording else f"{winding.voltage:.4g} V"
        text = f"is {gain:.3g} times what duty and speed let {volts} drive through "
        text += f"{winding.resistance:.3g} ohm"
        yield _finding(subject, text, gain)


def gain_of(subject: Subject, winding: Winding) -> float | None:
    """How many times too large the current is, by its law; None where that does not hold."""
    law = next((each for each in laws(subject) if each.name == "winding"), None)
    if law is None or law.of != "current":
        return None
    scale = np.abs(law.columns).max(axis=0)
    columns = law.columns / np.where(scale > 0.0, scale, 1.0)
    found, *_ = np.linalg.lstsq(columns, law.drive, rcond=None)
    left = float(np.std(law.drive - columns @ found))
    speed, voltage = (float(found[k] / max(scale[k], 1e-300)) for k in (0, 1))
    if left > LEFT * float(np.std(law.drive)) or voltage <= 0.0 or speed >= 0.0:
        return None
    volts = 1.0 if "supply" in subject.recording else winding.voltage
    constant = -speed / voltage * volts / winding.constant
    if max(constant, 1.0 / constant) > CONSTANT:
        return None  # the duty, the motion or the machine is another
    return voltage / volts * winding.resistance


def _bounded(subject: Subject, winding: Winding, moved: str) -> Iterator[Finding]:
    """A motor that drives has no more than what the supply leaves beside its back EMF."""
    recording = subject.recording
    speed = speed_of(subject, recording[moved])
    current = running_median(recording["current"])
    volts = max(float(np.median(recording["supply"])) if "supply" in recording else 0.0,
                winding.voltage)  # fmt: skip
    back = winding.constant * np.abs(speed)
    if float(back.max()) > FREE * volts:
        return
    most = (VOLTAGE * volts - back) / winding.resistance
    size = np.abs(current) - 4.0 * noise(recording["current"])
    beyond = (current * speed > 0.0) & (size > MARGIN * most)
    if np.count_nonzero(beyond) < max(LONG, SHARE * beyond.size):
        return
    worst = int(np.argmax(np.where(beyond, size / most, 0.0)))
    text = f"reaches {subject.with_unit(float(current[worst]), 'current')}, where the supply "
    text += f"drives {subject.with_unit(float(most[worst]), 'current')} at most through "
    text += f"{winding.resistance:.3g} ohm"
    ratio, since = float(size[worst] / most[worst]), float(subject.time[worst])
    if ratio > WRONG:
        yield _finding(subject, text, 10.0 ** np.ceil(np.log10(ratio)), since)
        return
    text += ": check its unit and its scale, state motor.resistance and supply.voltage, or leave "
    text += "the current out"
    mend = mends.without(subject, "current")
    yield fault("unit", "current", text, time=since, size=ratio, mend=mend)


def _finding(subject: Subject, found: str, gain: float, time: float | None = None) -> Finding:
    power = 10.0 ** round(np.log10(gain))
    factor = power if abs(gain / power - 1.0) < ROUND else gain
    mend = mends.scaled(subject, "current", factor)
    text = f"{found}: its unit or its scale; convert with {mend[0]}, or state motor.resistance"
    return fault("unit", "current", text, time=time, size=gain, mend=mend)
