"""The sentence on what a residual goes with, on residuals of known kind."""

import numpy as np
import pytest

from hannes.campaigns.campaign import Entry
from hannes.campaigns.segments import Segment
from hannes.core.recording.recording import Recording
from hannes.identification.pattern.blocks import BLOCKS, _blocks
from hannes.identification.pattern.goes_with import goes_with

TIME = np.arange(0.0, 1.2, 1e-3)
ANGLE = 5.0 * (1.0 - np.cos(2.0 * np.pi * TIME / 1.2))
LOAD = np.maximum(ANGLE - 6.0, 0.0)
SPEED = np.gradient(ANGLE, TIME)
FLOORS = {"current": 1.0, "position": 1.0}
UNITS = {"time": "s", "position": "rad", "current": "A"}
RUNS = 5


class Rig:
    """A plant, as far as the sentence reads it."""

    judged = ("current", "position")

    def same_run(self, recording):
        return recording.experiment.encode()

    def phases(self, recording):
        return {"closing": SPEED > 0.5, "opening": SPEED < -0.5, "still": np.abs(SPEED) <= 0.5}

    def quantities(self, recording):
        load = LOAD if recording.experiment == "grasp" else np.zeros(TIME.size)
        return {"angle": ANGLE, "speed": SPEED, "load": load, "contact": (load > 0.1).astype(float)}


def sentence(shape, seed=0, runs=RUNS, conditions=("free", "grasp")):
    """Of a residual of the current, `shape(condition, run)`, under noise of one floor."""
    rng, segments, raw = np.random.default_rng(seed), [], []
    for condition in conditions:
        for run in range(runs):
            channels = {"time": TIME, "position": ANGLE, "current": ANGLE}
            recording = Recording(channels, UNITS, experiment=condition)
            entry = Entry(f"{condition}-{run}", recording, condition, number=len(segments))
            segments.append(Segment(entry, "fit", np.ones(TIME.size, bool)))
            noise = rng.standard_normal((2, TIME.size))
            made = np.broadcast_to(shape(condition, run), TIME.shape)
            raw.append({"current": made + noise[0], "position": noise[1]})
    return goes_with(Rig(), segments, raw, FLOORS)


def test_noise_alone_has_no_sentence():
    said = [sentence(lambda condition, run: 0.0, seed) for seed in range(30)]
    assert [each for each in said if each["statements"]] == []
    assert all(each["tested"] for each in said)


def test_what_drifts_about_a_mean_that_was_refitted_is_seen():
    said = sentence(lambda condition, run: 0.5 * (run - 2) * np.sin(9.0 * TIME))
    assert said["sentence"] == "Changes steadily from run to run."


@pytest.mark.parametrize("end", [0.095, 0.1, 1.2, 7.3])
def test_no_block_is_of_the_last_sample_alone(end):
    time = np.arange(0.0, end + 5e-4, 1e-3)
    recording = Recording({"time": time, "position": time}, {"time": "s", "position": "rad"})
    sizes = np.bincount(_blocks(Segment(Entry("", recording, ""), "fit", time >= 0.0)))
    assert sizes.size <= BLOCKS and sizes.min() >= min(5, time.size)


def test_a_drift_of_one_command_alone_is_seen():
    drifting, alone = lambda condition, run: 0.5 * (run - 3) * np.sin(9.0 * TIME), ("free",)
    assert "Changes steadily" in sentence(drifting, runs=7, conditions=alone)["sentence"]
    sizes = np.random.default_rng(2).standard_normal(7)
    said = sentence(lambda condition, run: sizes[run] * ANGLE, runs=7, conditions=alone)
    assert said["sentence"] == ""


@pytest.mark.parametrize("seed", range(12))
def test_what_differs_from_run_to_run_alone_has_no_sentence(seed):
    sizes = np.random.default_rng(seed).standard_normal(2 * RUNS)
    said = sentence(lambda condition, run: sizes[run + RUNS * (condition == "free")] * ANGLE)
    assert said["sentence"] == ""


KINDS = {
    "load": (
        lambda condition, run: (condition == "grasp") * LOAD,
        "In contact alone; nearly all of it in the current; grows with load; of one sign both ways",
    ),
    "friction": (
        lambda condition, run: 3.0 * np.tanh(SPEED),
        "Nearly all of it in the current; turns its sign with the motion",
    ),
    "lag": (
        lambda condition, run: 0.2 * SPEED,
        "Nearly all of it in the current; grows with speed; turns its sign with the motion",
    ),
    "angle": (
        lambda condition, run: 0.6 * ANGLE,
        "Nearly all of it in the current; grows with the angle; of one sign both ways",
    ),
    "drift": (
        lambda condition, run: 0.5 * (1 + run) * np.sin(9.0 * TIME),
        "Nearly all of it in the current; changes steadily from run to run",
    ),
    "opening": (
        lambda condition, run: 2.0 * (SPEED < -0.5),
        "While opening alone; nearly all of it in the current",
    ),
    "free": (
        lambda condition, run: 2.0 * (condition == "free"),
        'In "free" alone; nearly all of it in the current; of one sign both ways',
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_sentence_says_of_which_kind_a_residual_is(kind):
    shape, expected = KINDS[kind]
    said = sentence(shape)["sentence"].rstrip(".")
    for part in expected.split("; "):
        assert part.lower() in said.lower(), said
    assert said.count(";") == expected.count(";"), said


def test_a_sentence_needs_three_runs_of_a_command():
    assert sentence(KINDS["load"][0], runs=2) == {
        "sentence": "", "statements": [], "tested": False,
    }  # fmt: skip
