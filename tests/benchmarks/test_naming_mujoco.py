"""Campaigns of a hand in MuJoCo's own laws: near the truth's hand, and not the same."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.guarding.plan import SPREAD
from benchmarks.truth.campaign import make
from benchmarks.truth.parameters import FINGERS, OWN
from benchmarks.truth.protocol import PROTOCOLS
from hannes import Hand

pytest.importorskip("mujoco")

from benchmarks.naming_study.apart import mujoco_bench

SEED = 7


def once(plan):
    return replace(plan, conditions=tuple(replace(each, repeats=1) for each in plan.conditions))


@pytest.fixture(scope="module")
def plan():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mujoco_bench, "PLAN", once(mujoco_bench.PLAN))
        yield


@pytest.fixture(scope="module")
def sound(plan):
    return list(mujoco_bench.make(SEED, {}).recordings.values())


def test_it_is_near_the_truths_hand(sound):
    truth = make(once(PROTOCOLS["poor"]), SEED, {}, SPREAD)
    for mine, other in zip(sound, truth.recordings.values(), strict=True):
        assert len(mine) == len(other)
        assert mine["position"].max() == pytest.approx(other["position"].max(), rel=0.01)
        assert np.sqrt(np.mean((mine["current"] - other["current"]) ** 2)) < 0.1
    void, grasp = sound
    assert "force" not in void and grasp["force"].max() > 100.0
    assert 'controller = "continuous"' in grasp.experiment and grasp.source == "measured"


def test_slack_lets_the_motor_turn_further_before_the_force_rises(sound, plan):
    loose = mujoco_bench.make(SEED, {"leader_slack.length": 3e-3}).recordings["02_dynamometer"]
    turned = loose["position"].max() - sound[1]["position"].max()
    assert 0.2 < turned < 3e-3 / Hand().parameters["gear.pulley_radius"] * 1.2
    assert loose["force"].max() < 0.95 * sound[1]["force"].max()


def test_friction_by_load_takes_force_in_the_grasp_alone(sound, plan):
    loaded = mujoco_bench.make(SEED, {"gear_load.coefficient": 0.1}).recordings
    assert loaded["02_dynamometer"]["force"].max() < 0.96 * sound[1]["force"].max()
    void = loaded["01_void"]["position"] - sound[0]["position"]
    assert np.abs(void).max() < 0.1


def test_each_joint_is_off_for_itself_there_too():
    values, _ = mujoco_bench.real_hand(mujoco_bench.parse_hand("base = 'hannes'"), SEED, SPREAD)
    found = Hand().with_values(mujoco_bench.library_names(values)).parameters
    for name in OWN:
        _, _, what = name.partition(".")
        assert [found[f"{f}.{what}"] for f in FINGERS] == pytest.approx(values[name])
