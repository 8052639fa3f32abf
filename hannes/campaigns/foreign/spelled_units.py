"""Units as logs spell them."""

from collections.abc import Sequence

# Spellings of units as logs have them, and as a mapping has them.
UNITS = {
    "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s",
    "sek": "s", "sekunden": "s", "secondes": "s", "secondi": "s", "segundos": "s",
    "ms": "ms", "msec": "ms", "millis": "ms", "milliseconds": "ms",
    "us": "us", "µs": "us", "μs": "us", "usec": "us", "micros": "us", "microseconds": "us",
    "ns": "ns", "nsec": "ns", "nanoseconds": "ns",
    "rad": "rad", "radian": "rad", "radians": "rad", "mrad": "mrad",
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "grad": "deg",
    "rad/s": "rad/s", "deg/s": "deg/s", "rpm": "rpm",
    "a": "A", "amp": "A", "amps": "A", "ampere": "A", "ma": "mA", "milliamps": "mA",
    "v": "V", "volt": "V", "volts": "V", "mv": "mV",
    "n": "N", "newton": "N", "newtons": "N", "mn": "mN", "kn": "kN",
    "nm": "N m", "n*m": "N m", "n·m": "N m", "m": "m", "mm": "mm",
    "%": "%", "percent": "%", "1": "1", "-": "1",
}  # fmt: skip
COUNTS = ("count", "counts", "cnt", "tick", "ticks", "raw", "lsb", "steps", "adc")


def unit_of(text: str) -> str | None:
    """The unit that a text spells, None where it spells none."""
    return UNITS.get(text.strip().lower())


def are_units(cells: Sequence[str]) -> bool:
    """Whether most of the cells of a row that are not empty are units."""
    words = [word for cell in cells if (word := cell.strip(" ()[]"))]
    return bool(words) and sum(unit_of(word) is not None for word in words) * 2 > len(words)
