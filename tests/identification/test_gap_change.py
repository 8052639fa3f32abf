"""The change of a gap against chance: how often it is called worse where nothing is worse."""

import numpy as np
import pytest
from sled import TIMES, UNITS, Sled

from hannes.campaigns.campaign import Entry
from hannes.campaigns.segments import Segment
from hannes.core.recording.recording import Recording
from hannes.identification.gap_change import (
    FALL_LEVEL,
    LEVEL,
    GapChange,
    _freedom,
    gap_changes,
    refusal,
)

SHAPE = np.sin(5.0 * TIMES)
FLOORS = {"position": 0.01, "speed": 0.1}


def runs(rng, condition, fitted, shown, spread):
    """Runs of one command: those fitted, those not; they differ along one shape."""
    made = []
    for k in range(fitted + shown):
        channels = {
            "time": TIMES,
            "drive": np.full(TIMES.size, float(len(condition))),
            "position": spread * rng.standard_normal() * SHAPE,
            "speed": 0.0 * TIMES,
        }
        role = "fit" if k < fitted else "show"
        entry = Entry(f"{condition}{k}", Recording(channels, UNITS), condition, role)
        made.append(Segment(entry, role, TIMES >= 0.0))
    return made


def called(seed, conditions):
    """Whether the second of two simulations as near to the truth is called worse, and better.

    Both are off from the mean of the runs fitted by as much, one way and the other.
    """
    rng = np.random.default_rng(seed)
    sets = [runs(rng, *each) for each in conditions]
    raws = []
    for side in (-1.0, 1.0):
        raw = []
        for some in sets:
            mean = np.mean([s.recording["position"] for s in some if s.role == "fit"], axis=0)
            raw += [
                {"position": mean + 0.3 * side * SHAPE - s.recording["position"],
                 "speed": 0.0 * TIMES}
                for s in some if s.role == "show"
            ]  # fmt: skip
        raws.append(raw)
    segments = [each for some in sets for each in some]
    shown = [each for each in segments if each.role == "show"]
    position, _ = gap_changes(Sled(), segments, shown, *raws, FLOORS)
    return position.worse, position.better


@pytest.mark.parametrize(
    "conditions",
    [
        [("a", 2, 1, 1.0), ("bb", 14, 1, 0.02)],  # three runs decide, fifteen quiet ones do not
        [("a", 2, 12, 1.0)],  # twelve unfitted runs share the error of a mean of two
    ],
)
def test_what_is_not_worse_is_rarely_called_so(conditions):
    worse, better = np.mean([called(seed, conditions) for seed in range(600)], axis=0)
    assert worse <= 2.5 * LEVEL
    assert better <= 2.5 * FALL_LEVEL


def test_a_name_whose_gaps_fall_by_what_chance_seldom_gives_is_not_refused():
    """As position and force of six repeats: three and a half deviations, where it would show."""
    fall = GapChange("position", "rad", 0.025, 0.005, -1.4, -3.0, 0.39, 4.77, 3.16)
    assert refusal([fall]) == ""
    little = GapChange("position", "rad", 0.025, 0.024, -0.4, -3.0, 0.39, 4.77, 3.16)
    assert "no gap falls" in refusal([little])


def test_freedom_is_that_of_the_command_that_decides():
    assert _freedom([(1.0, 3.0)]) == pytest.approx(3.0)
    assert _freedom([(1.0, 1.0), (1e-6, 50.0)]) == pytest.approx(1.0, rel=1e-4)
    assert _freedom([(1.0, 5.0), (1.0, 5.0)]) == pytest.approx(10.0)
    assert _freedom([(0.0, 5.0)]) == 5.0
