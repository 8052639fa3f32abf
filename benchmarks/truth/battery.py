"""A supply that falls from run to run, put into each run's hand before it is scattered.

    V_k = V_0 exp(-k fall / V_0),  k: number of the run from 0

so that a run takes a share of what is left: at first `fall`, later less. Range: a large pack in
short runs (10 mV) to a small and worn one (0.2 V), which after a dozen runs is nearly empty.
Source: Tremblay & Dessaint (2009), the exponential zone of a battery's discharge.
"""

from collections.abc import Mapping
from math import exp
from typing import Any

from benchmarks.truth.parameters import NOMINAL
from benchmarks.truth.size import Size

FALL = "falling_supply.fall"
RANGES = {FALL: Size("V", 0.01, 0.2)}
_SUPPLY = "supply.voltage"


def drained(values: Mapping[str, Any], hidden: Mapping[str, float], before: int) -> dict[str, Any]:
    """The hand with the supply that is left after so many runs; `values` may lack a voltage."""
    full = values.get(_SUPPLY, NOMINAL[_SUPPLY])
    return {**values, _SUPPLY: full * exp(-before * hidden[FALL] / full)}
