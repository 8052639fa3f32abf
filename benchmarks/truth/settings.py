"""Settings of a hand that are other than its user says, put into a hand after it was drawn.

Ranges are physical: a hand that lies on its side or hangs, gains tuned to a half or to twice as
much, a limit of the current that a user sets to spare the fingers.
"""

from collections.abc import Mapping
from typing import Any

from benchmarks.truth.parameters import NOMINAL
from benchmarks.truth.size import Size

WEIGHT = 9.81  # m/s2
RANGES = {  # share of gravity; share of a gain; A
    "mounting.along_x": Size("1", -1.0, 1.0),
    "mounting.along_y": Size("1", -1.0, 1.0),
    "firmware_gains.proportional": Size("1", -0.5, 1.0),
    "firmware_gains.derivative": Size("1", -0.5, 1.0),
    "current_limit.change": Size("A", -3.5, -2.0),
}
_PLACES = {
    "mounting.along_x": "gravity.x",
    "mounting.along_y": "gravity.y",
    "firmware_gains.proportional": "position_pid.proportional",
    "firmware_gains.derivative": "position_pid.derivative",
    "current_limit.change": "position_pid.limit",
}


def changed(values: Mapping[str, Any], setting: str, size: float) -> dict[str, Any]:
    """The hand with one setting moved by its size; `values` holds every number of it."""
    out, place = dict(values), _PLACES[setting]
    if setting.startswith("mounting"):
        out[place] += WEIGHT * size
    elif setting.startswith("firmware_gains"):
        out[place] *= 1.0 + size
    else:
        out[place] += size
    return out


def set_otherwise(values: Mapping[str, Any], hidden: Mapping[str, float]) -> dict[str, Any]:
    """The hand with every setting of `hidden` moved; `values` may lack what is nominal."""
    out = dict(values)
    for name, size in hidden.items():
        if name in RANGES:
            place = _PLACES[name]
            out[place] = changed({**NOMINAL, **out}, name, size)[place]
    return out
