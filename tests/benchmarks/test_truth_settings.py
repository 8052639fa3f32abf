"""Settings other than stated, and noise with a bandwidth, in the independent truth."""

import numpy as np
import pytest

from benchmarks.truth.bench import CURRENT
from benchmarks.truth.campaign import make
from benchmarks.truth.hidden import SIZES, of_effects
from benchmarks.truth.noise import RATE, current_noise
from benchmarks.truth.parameters import NOMINAL, named
from benchmarks.truth.protocol import POOR, Condition, Protocol
from benchmarks.truth.settings import RANGES, set_otherwise
from hannes.plants.hand.other_settings import other_settings
from hannes.simulation.hand.hand import Hand

BLINK = Protocol((Condition("void", ((0.0, 0.0), (0.1, 1.5)), 1),), POOR)


@pytest.mark.parametrize("name", RANGES)
def test_a_setting_is_the_same_in_both(name):
    """The library's own move of the hand's values."""
    effect, _, amplitude = name.partition(".")
    own = other_settings(Hand().parameters)[effect]
    size = RANGES[name].low
    moved = {key: NOMINAL[key] + by * size for key, by in own.moves[amplitude].items()}
    mine, theirs = named(moved), set_otherwise(NOMINAL, {name: size})
    for key, value in theirs.items():
        assert np.allclose(mine[key], value, rtol=1e-12), key
    assert theirs != NOMINAL


def test_a_setting_is_hidden_by_name_as_an_effect_is():
    found = make(BLINK, 3, {"firmware_gains.proportional": 0.8, "gear_load.coefficient": 0.05})
    alone = make(BLINK, 3, {"gear_load.coefficient": 0.05})
    assert found.answer["effects"]["firmware_gains"] == {"proportional": 0.8}
    (one,), (other,) = found.recordings.values(), alone.recordings.values()
    assert not np.allclose(one["current"], other["current"], atol=0.03)
    assert of_effects({"mounting.along_x": 1.0}) == {}


def test_signs_of_a_range():
    assert SIZES["current_limit.change"].signs == {"minus": (-1.0, 2.0, 3.5)}
    assert SIZES["gear_load.coefficient"].signs == {"plus": (1.0, 0.003, 0.2)}
    gains = SIZES["firmware_gains.derivative"].signs
    assert gains == {"plus": (1.0, 0.0, 1.0), "minus": (-1.0, 0.0, 0.5)}


def test_coloured_noise_has_the_same_level_and_the_stated_bandwidth():
    white, slow = (current_noise(np.random.default_rng(1), 200_000, f) for f in (None, 100.0))
    np.testing.assert_array_equal(
        white, CURRENT * np.random.default_rng(1).standard_normal(white.size)
    )
    assert slow.std() == pytest.approx(CURRENT, rel=0.02)
    kept = np.corrcoef(slow[1:], slow[:-1])[0, 1]
    assert kept == pytest.approx(np.exp(-2.0 * np.pi * 100.0 / RATE), abs=0.01)


def test_a_campaign_may_have_coloured_noise():
    (slow,), (white,) = (make(BLINK, 3, bandwidth=f).recordings.values() for f in (20.0, None))
    differs = slow["current"] - white["current"]
    assert 0.0 < np.std(differs) < 10.0 * CURRENT
    assert make(BLINK, 3, bandwidth=20.0).answer["noise_bandwidth_hz"] == 20.0
