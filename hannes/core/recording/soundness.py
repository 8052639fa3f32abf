"""What makes a recording: names, units, equally long finite channels, a clock that goes forward."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hannes.core.errors import BadInput
from hannes.core.io.limits import MAGNITUDE

FloatArray = NDArray[np.float64]
SOURCES = ("simulated", "measured")

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,63}")
_UNIT = re.compile(r"[A-Za-z0-9%µμΩ°²³·^*/()-](?:[A-Za-z0-9%µμΩ°²³·^*/(). -]{0,31})(?<! )")


def check_names(channels: Mapping[str, Any], units: Mapping[str, str]) -> None:
    """Raise BadInput unless every channel has a sound name and unit, and time is there."""
    for name in channels:
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            raise BadInput(f"{name!r:.80} is no channel name: expected letters, digits, _ . -")
        if not isinstance(unit := units.get(name), str) or not _UNIT.fullmatch(unit):
            raise BadInput(f'channel "{name}" needs a unit ("1" for none), got {unit!r:.80}')
    for name in units:
        if name not in channels:
            raise BadInput(f'a unit is given for "{name}", which is no channel')
    if units.get("time") != "s":
        raise BadInput("a recording needs the column time_s (channel time, unit s)")
    if len(channels) < 2:
        raise BadInput("a recording needs at least one channel besides time")


def frozen(name: str, values: Any) -> FloatArray:
    """Return a read-only float64 copy; raise BadInput unless 1-D, real, finite and not masked."""
    try:
        array = np.asarray(values)
    except ValueError:
        array = np.empty(())  # rows of unequal length
    if array.ndim != 1 or array.dtype.kind not in "fiu" or np.ma.is_masked(values):
        raise BadInput(f'channel "{name}": expected a row of real numbers')
    with np.errstate(over="ignore"):
        copy = array.astype(np.float64)
    if not np.isfinite(copy).all():
        raise BadInput(
            f'channel "{name}" is not finite at sample {int(np.isfinite(copy).argmin())}'
        )
    if (beyond := np.abs(copy) > MAGNITUDE).any():
        place = int(beyond.argmax())
        raise BadInput(
            f'channel "{name}" is {copy[place]:.6g} at sample {place}, beyond {MAGNITUDE:g}: no '
            "sensor reads that; is the file damaged, or the value a mark for none?"
        )
    copy.flags.writeable = False
    return copy


def check_time(arrays: Mapping[str, FloatArray]) -> None:
    """Raise BadInput unless channels are as long as time, and time increases."""
    time = arrays["time"]
    for name, each in arrays.items():
        if len(each) != len(time):
            raise BadInput(f'channel "{name}" has {len(each)} samples, time has {len(time)}')
    if len(time) < 2:
        raise BadInput(f"a recording needs at least two samples, got {len(time)}")
    stalled = np.flatnonzero(time[1:] <= time[:-1])
    if stalled.size:
        raise BadInput(f"time does not increase from sample {stalled[0]} to {stalled[0] + 1}")


def check_metadata(recording: Any, schema: str) -> None:
    """Raise BadInput unless texts, schema, source and seed are what they may be."""
    for name in ("plant", "experiment", "hand", "conversion"):
        if not _is_text(getattr(recording, name)):
            raise BadInput(f"{name} of a recording must be text, without NUL or lone surrogates")
    if recording.schema != schema:
        raise BadInput(f"schema {recording.schema!r:.80} is unknown, expected {schema!r}")
    if recording.source not in SOURCES:
        raise BadInput(f"source {recording.source!r:.80} is neither {' nor '.join(SOURCES)}")
    seed = recording.seed
    if seed is not None and not (type(seed) is int and 0 <= seed < 2**63):
        raise BadInput(f"seed {seed!r:.80} is not a whole number from 0 to 2^63 - 1")


def _is_text(value: object) -> bool:
    return isinstance(value, str) and not re.search("[\0\ud800-\udfff]", value)
