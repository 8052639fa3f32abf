"""Parts of a machine are put where a fit has them: what is linear of them is then little."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.few.cases import FULL
from benchmarks.truth import campaign as truth
from benchmarks.truth.protocol import RICH, Protocol
from hannes.campaigns.campaign import Entry
from hannes.identification.diagnosis import parts_as_fitted
from hannes.identification.diagnosis.baseline import ROUGH
from hannes.identification.diagnosis.before_after import simulated
from hannes.identification.diagnosis.fitted_deviations import deviations
from hannes.identification.diagnosis.gauss_newton import settled
from hannes.identification.diagnosis.linearisation import begun, with_noise
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.part_deviations import of_parts, part_deviations
from hannes.identification.diagnosis.parts_as_fitted import about, with_parts_as_fitted
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.plants.axis.plant import Axis
from hannes.plants.hand.finger_faults import FAULTS
from hannes.plants.hand.plant import HandPlant

OFF = {"index_mcp.moment_arm": 0.02, "ring_pip.spring_stiffness": -0.02}


def test_a_hand_whose_joints_are_off_is_one_of_other_shares():
    stated = HandPlant().with_values({"index.mcp_moment_arm": 1.1})
    moved = stated.with_parts(OFF).parameters
    assert moved["index.mcp_moment_arm"] == pytest.approx(1.1 * 1.02)
    assert moved["ring.pip_spring_stiffness"] == pytest.approx(0.98)
    assert moved["index.pip_moment_arm"] == 1.0
    assert stated.with_parts({"ring_pip.moment_arm": -2.0}).parameters["ring.pip_moment_arm"] == 0.0


@pytest.fixture(scope="module")
def point():
    """A fit to the mean closure of a hand whose joints are off, known far better than that."""
    made = truth.make(Protocol((FULL,), RICH), 4)
    plant, recording = HandPlant(), next(iter(made.recordings.values()))
    groups = grouped(plant, [Entry("run", recording, FULL.name, "fit")])
    settings = Settings(0.02, 0.005, scatter_apart=0.01)
    model = Model(plant, groups, ParameterSpace(plant, groups, settings, ()), ())
    x = np.zeros(model.space.size)
    there = begun(model, x, model.space.uncertain, ROUGH, 0, part_deviations(model, x))
    noise, rng = there.noise, np.random.default_rng(4)
    off = {name: rng.standard_normal() for name in of_parts(deviations(there, 1.0))}
    vector = model.with_parts_at(off).vectors(groups[0], x[np.newaxis], False)[0]
    groups[0].measured = (vector + noise.discretisation[0])[np.newaxis]
    covariances = [4e-3 * each for each in noise.covariances]
    return settled(with_noise(there, replace(noise, covariances=covariances)))


def test_parts_about_which_a_machine_is_simulated_are_expected_where_they_were(point):
    """By their rows the moved machine is the former one, up to what is not linear."""
    off = {name: 0.3 * each for name, each in of_parts(deviations(point, 1.0)).items()}
    moved = point.model.with_parts_at(off)
    parts = part_deviations(moved, point.x)
    assert parts.at == off
    noise = replace(point.noise, model=moved, parts=parts)
    (explained,) = parts.explained(moved.groups)
    (before,), (after,) = point.vectors, about(point, noise).vectors
    left = [point.noise.white(0, each) for each in (after - before - explained, after - before)]
    assert np.linalg.norm(left[0]) < 0.5 * np.linalg.norm(left[1])


def test_what_is_not_linear_in_parts_is_simulated(point):
    found = with_parts_as_fitted(point)
    assert found.model.parts_at
    assert found.chi2 < 0.5 * point.chi2


def test_parts_farther_off_than_like_parts_are_left_alone(point, monkeypatch):
    monkeypatch.setattr(parts_as_fitted, "of_parts", lambda rows: {"index_mcp.moment_arm": 4.1})
    assert with_parts_as_fitted(point) is None


def test_a_plant_that_cannot_move_its_parts_is_left_alone(point):
    model = copy(point.model)
    model.small = Axis()
    assert with_parts_as_fitted(replace(point, noise=replace(point.noise, model=model))) is None


def test_the_stated_machine_has_no_part_off(point):
    """Nor has the machine that is written; a fault is added to what is simulated."""
    space = ParameterSpace(
        HandPlant(), point.model.groups, Settings(), (FAULTS["index_weak_spring"],)
    )
    off = HandPlant().with_parts({"index_mcp.spring_stiffness": 0.01}).parameters
    moved, x = space.simulating(off), np.zeros(space.size)
    x[space.place("index_weak_spring.mcp_lost")] = space.parameters[-2].x(0.3)
    (group,) = point.model.groups
    name = "index.mcp_spring_stiffness"
    assert moved.columns(group, x[np.newaxis], True)[name] == pytest.approx(0.71)
    assert moved.values(x)[name] == pytest.approx(0.7)
    model = point.model.with_parts_at({"index_mcp.moment_arm": 2.0})
    entries, places = point.model.groups[0].entries, np.zeros((2, point.x.size))
    given, here = simulated(model, entries, places, as_given=1)[0]
    stated, _ = simulated(point.model, entries, places)[0]
    np.testing.assert_array_equal(given["position"], stated["position"])
    assert np.any(given["position"] != here["position"])
    both = simulated(model, entries, places)[0]
    np.testing.assert_array_equal(both[0]["position"], both[1]["position"])
