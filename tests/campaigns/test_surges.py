"""A drive's surge that few samples resolve is no outlier, nor is a noisy count a late start."""

import numpy as np
import pytest

from hannes.campaigns.check import check
from hannes.campaigns.quality.subject import Subject
from hannes.campaigns.quality.zero import begins_moving
from hannes.core.recording.recording import Recording

TIME = 0.01 * np.arange(500)
COUNT = 2.0 * np.pi / 4096
NOISE = np.random.default_rng(1).standard_normal((2, TIME.size))


def servo(surge=(), at=100, **odd):
    """Rest with a noisy current in which a surge begins at a sample; `odd` readings by index."""
    current = 0.01 * NOISE[0]
    current[at : at + len(surge)] += surge
    for place, value in odd.items():
        current[int(place[1:])] = value
    return Recording({"time": TIME, "current": current}, {"time": "s", "current": "A"})


def found(recording, kind):
    return [each for each in check(recording) if each.kind == kind]


INRUSH = (2.3, 1.8, 1.4, 1.1, 0.8, 0.6, 0.4, 0.3, 0.2, 0.1)
BRAKING = (0.77, 0.79, 0.795, 0.29, -0.62, -0.99, -0.97, -0.64, -0.34, -0.03, 0.22, 0.38, 0.45,
           0.41, 0.32, 0.21, 0.12, 0.06)  # fmt: skip


@pytest.mark.parametrize("surge", [INRUSH, BRAKING], ids=["inrush", "braking"])
def test_a_surge_is_no_outlier(surge):
    assert not found(servo(surge), "jump")


@pytest.mark.parametrize("surge", [(), INRUSH, BRAKING], ids=["rest", "inrush", "braking"])
def test_a_reading_that_neighbours_contradict_is_one_beside_a_surge_too(surge):
    (one,) = found(servo(surge, n300=2.0), "jump")
    assert one.time == TIME[300] and "1 reading" in one.text
    for second in (2.1, 2.4, 1.7):
        (two,) = found(servo(surge, n300=2.0, n301=second), "jump")
        assert two.time == TIME[300] and "2 readings" in two.text


def moving(first):
    """A sweep from rest, of which the first positions are some counts of an encoder."""
    angle = 0.7 * np.sin(2.4 * np.maximum(TIME - 0.05, 0.0)) + 0.3 * COUNT * NOISE[1]
    counts = np.rint(angle / COUNT)
    counts[: len(first)] = first
    return Recording({"time": TIME, "position": COUNT * counts}, {"time": "s", "position": "rad"})


@pytest.mark.parametrize(
    ("first", "moves"),
    [((1, -1), False), ((0, 2, 0, 0), False), ((0, 9, 18, 27, 36), True), ((0, 9, 13, 18), True)],
    ids=["noise", "a count", "under way", "unevenly"],
)
def test_two_noisy_counts_are_no_late_start(first, moves):
    assert begins_moving(Subject(moving(first)), "position") is moves
