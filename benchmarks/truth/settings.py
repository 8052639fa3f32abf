"""Settings of a hand that are other than its user says, put into a hand after it was drawn.

Ranges are physical: a hand that lies on its side or hangs, gains tuned to a half or to twice as
much, a limit of the current that a user sets to spare the fingers.
"""

from collections.abc import Mapping
from typing import Any

WEIGHT = 9.81  # m/s2
# Setting -> least and largest size: share of gravity, share of a gain, A.
RANGES = {
    "mounting.along_x": (-1.0, 1.0),
    "mounting.along_y": (-1.0, 1.0),
    "firmware_gains.proportional": (-0.5, 1.0),
    "firmware_gains.derivative": (-0.5, 1.0),
    "current_limit.change": (-3.5, -2.0),
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
