"""Whether a scattered hand is still a hand: it grasps, with drive to spare, and opens again."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.truth.protocol import DYNAMOMETER, PAPER, REST, SOFT_BALL
from benchmarks.truth.simulation import simulate, trace
from benchmarks.truth.state import ANGLE

MOST_DUTY = 0.97
CONTACT = (0.1, 0.6)  # s, of the first force above 1 N
LEAST_FORCE = 30.0  # N, at the peak
OPEN = 0.35  # of any joint's excursion, at the end


def fit(values: Mapping[str, Any]) -> bool:
    """Judge the paper's grasp of the dynamometer, and that the open hand clears both objects.

    Unsaturated duty, contact while closing, at least 30 N, open at the end.
    """
    try:
        ran, states = trace(values, PAPER, object=DYNAMOMETER, duration=PAPER[-1][0] + REST)
    except RuntimeError:
        return False
    pressing = np.flatnonzero(ran["force_N"] > 1.0)
    excursion = states[:, ANGLE : ANGLE + 10] - states[0, ANGLE : ANGLE + 10]
    first = ran["time_s"][pressing[0]] if pressing.size else np.inf
    return bool(
        np.abs(ran["duty_1"]).max() < MOST_DUTY
        and CONTACT[0] < first < CONTACT[1]
        and ran["force_N"].max() > LEAST_FORCE
        and (excursion[-1] < OPEN * excursion.max(axis=0)).all()
        and _clears(values, SOFT_BALL)
    )


def _clears(values: Mapping[str, Any], thing: Mapping[str, Any]) -> bool:
    ran = simulate(values, ((0.0, 0.0), (1.0, 0.0)), object=thing, duration=2e-3)
    return bool(ran["force_N"].max() == 0.0)
