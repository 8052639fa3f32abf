"""A hand that is known by a recording of its empty closure."""

from dataclasses import replace

import numpy as np
import pytest

from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.dataset.empty_closure import empty_means
from hannes.recognition.known_hand import checked, hand_numbers, unknown_hand
from tests.bench.drawn_model import HANDS, NUMBERS, drawn_model, drawn_networks


@pytest.fixture(scope="module")
def model():
    return drawn_model()


def closure(seconds=1.7, idle=0.0):
    """A recording of a closure that begins after `idle` seconds."""
    time = np.arange(round(1e3 * (seconds + idle))) / 1e3
    since = np.maximum(time - idle, 0.0)
    asked = np.interp(since, [0.0, 0.637, 0.9, 1.4], [0.0, 9.84, 9.84, 0.0])
    current, position = 0.3 * np.sign(asked) + 0.02 * np.sin(9.0 * since), 0.9 * asked
    channels = {"time": time, "current": current, "position": position, "reference": asked}
    return Recording(channels, {"time": "s", "current": "A", "position": "rad", "reference": "rad"})


def test_numbers_are_means_from_the_start_of_the_command_on(model):
    found, made = hand_numbers(closure(), model), closure()
    assert found.shape == (NUMBERS,)
    channels = (made[name] for name in ("current", "position", "reference"))
    assert np.array_equal(found, empty_means(*channels, 20, NUMBERS))
    assert hand_numbers(closure(idle=0.3), model) == pytest.approx(found, abs=1e-9)


def without(made, begin, end):
    """The recording without its samples from `begin` to `end` [s]."""
    kept = (made.time < begin - 1e-9) | (made.time > end + 1e-9)
    return Recording({name: values[kept] for name, values in made.items()}, made.units)


@pytest.mark.parametrize(
    "idle, begin, end, why",
    [
        (
            0.0,
            0.700,
            0.720,
            r"a gap of 22 ms, from 0.699 s on: expected samples at most 2.5 ms apart",
        ),
        (0.0, 0.001, 0.005, "a gap of 6 ms, from 0.000 s on"),
        (0.0, 1.590, 1.605, "a gap of 17 ms, from 1.589 s on"),
        (0.3, 0.290, 0.310, "a gap of 22 ms, from 0.289 s on"),
        (0.0, 0.801, 0.802, "a gap of 3 ms"),
        (0.0, 0.000, 0.029, "at 0.463 rad already: 0.030 s are missing"),
    ],
)
def test_a_closure_with_a_gap_is_refused(model, idle, begin, end, why):
    with pytest.raises(BadInput, match=why) as said:
        hand_numbers(without(closure(idle=idle), begin, end), model)
    assert "hannes port" in str(said.value) and "record the closure anew" in str(said.value)


def test_a_hand_that_rests_a_little_closed_before_the_command_is_no_matter(model):
    made, found = closure(idle=0.3), hand_numbers(closure(idle=0.3), model)
    resting = np.where(made.time < 0.3, 0.05, made["reference"])
    left = Recording({**made, "reference": resting}, made.units)
    assert hand_numbers(left, model) == pytest.approx(found, abs=0.02)


def shifted(made, by):
    return Recording({**made, "time": made.time + by}, made.units)


def test_a_clock_that_does_not_start_at_0_is_no_matter(model):
    found = hand_numbers(closure(), model)
    assert hand_numbers(shifted(closure(), 1.75e3), model) == pytest.approx(found, abs=1e-6)
    with pytest.raises(BadInput, match=r"0.463 rad already: 0.030 s are missing; expected all"):
        hand_numbers(shifted(without(closure(), 0.0, 0.029), -0.03), model)


@pytest.mark.parametrize("every, rate", [(3, 333), (5, 200), (20, 50)])
def test_a_closure_that_is_sampled_too_slowly_is_refused_as_such(model, every, rate):
    made = closure(2.0)
    slow = Recording({name: values[::every] for name, values in made.items()}, made.units)
    with pytest.raises(BadInput, match=f"at {rate} Hz: expected at least 400 Hz") as said:
        hand_numbers(slow, model)
    assert "gap" not in str(said.value) and "hannes port" not in str(said.value)


def test_a_closure_of_500_Hz_is_taken(model):
    made = closure()
    half = Recording({name: values[::2] for name, values in made.items()}, made.units)
    assert hand_numbers(half, model) == pytest.approx(hand_numbers(closure(), model), abs=0.02)


def test_what_is_missing_beside_the_closure_is_no_matter(model):
    found = hand_numbers(closure(), model)
    for idle, begin, end in ((0.3, 0.1, 0.2), (0.0, 1.62, 1.65)):
        left = without(closure(idle=idle), begin, end)
        assert hand_numbers(left, model) == pytest.approx(found, abs=1e-9)


def test_one_sample_that_is_missing_hardly_changes_a_number(model):
    found = hand_numbers(closure(), model)
    for begin in np.arange(0.01, 1.6, 0.0123):
        left = hand_numbers(without(closure(), begin, begin + 0.9e-3), model)
        assert np.abs(left - found).max() < 0.01


@pytest.mark.parametrize(
    "recording, pressed, why",
    [
        (closure(1.2), drawn_networks(), "too short"),
        (closure(), drawn_networks(hands=0), "nothing of empty closures"),
        (closure(), None, "nothing of empty closures"),
        (
            closure(),
            replace(drawn_networks(), reach=np.array([1e3] + [1e-3] * HANDS)),
            "was something held",
        ),
    ],
)
def test_what_is_no_empty_closure_is_refused(model, recording, pressed, why):
    with pytest.raises(BadInput, match=why):
        hand_numbers(recording, replace(model, pressed=pressed))


def test_numbers_of_another_model_are_refused(model):
    assert checked(np.full(NUMBERS, 0.3), model) is not None
    for numbers in (np.zeros(3), np.full(NUMBERS, np.inf)):
        with pytest.raises(BadInput):
            checked(numbers, model)


def test_a_hand_that_is_not_known_is_named_where_the_model_knows_hands(model):
    assert "off by 10.0 %, by 5.0 % after an empty closure" in unknown_hand(model)
    assert not unknown_hand(replace(model, pressed=None))
    assert not unknown_hand(replace(model, pressed=drawn_networks(hands=0)))
