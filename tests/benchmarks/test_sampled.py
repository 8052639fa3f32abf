"""Time and error of ticks in one step."""

import numpy as np
import pytest

from benchmarks import sampled
from hannes.simulation.rodas import source


def test_the_former_way_is_without_whole_ticks():
    now = source.source()
    with sampled.as_continuous():
        former = source.source()
    assert now != former and "if False:" in former
    assert source.source() == now


def test_hands_differ_and_all_are_sampled():
    found = sampled.grasps(30.0)
    assert len(found) == sampled.HANDS * len(sampled.EXPERIMENTS)
    assert all(experiment.controller == "sampled" for _, experiment in found)
    assert {hand.parameters["encoder.bits"] for hand, _ in found} == {30.0}
    assert len({hand.parameters["motor.dry_friction"] for hand, _ in found}) == len(found)


def test_errors_are_shares_of_a_peak_and_nil_traces_have_none():
    exact = np.array([[1.0, -2.0], [0.0, 0.0], [4.0, 0.0]])
    found = exact + np.array([[0.02, 0.02], [0.5, 0.5], [0.0, 0.4]])
    pressed = np.array([[0.0], [10.0], [0.0]])
    rows = sampled.errors([found, found + pressed], [exact, exact + pressed])
    assert rows["current_rms_%"] == pytest.approx(1.0)
    assert rows["leader_tension_worst_%"] == pytest.approx(10.0)
    assert rows["force_worst_%"] == pytest.approx(5.0)  # of the grasp that has one
