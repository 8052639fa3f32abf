"""A law that is not linear, by a bridge's dead time or a sensor's lag, is no slipping encoder."""

import pytest

from benchmarks.truth.campaign import make
from benchmarks.truth.protocol import DYNAMOMETER, PAPER, RICH, Condition, Protocol, scaled
from hannes.campaigns.check import check
from hannes.plants.hand.plant import HandPlant

SLOW = Condition("dynamometer, 0.25 speed", scaled(PAPER, 0.25), 2, DYNAMOMETER, sensor=True)


@pytest.mark.parametrize(
    ("seed", "hidden"),
    [(2, {"current_lag.time": 0.0121}), (1, {"bridge_dead_time.share": 0.067})],
)
def test_a_law_that_is_not_linear_is_no_slip(seed, hidden):
    made = make(Protocol((SLOW,), RICH), seed, hidden)
    for recording in made.recordings.values():
        assert "slip" not in [each.kind for each in check(recording, HandPlant())]
