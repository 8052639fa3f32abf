"""The shape of what cannot be named, on a sled whose rail is wavy and whom no law explains."""

import json
from dataclasses import replace

import numpy as np
import pytest
from sled import GUST, PLACED, TURBULENCE, UNITS, Described, Sled, campaign, effect

from hannes.commands.diagnose import diagnose
from hannes.core.kernels.jit import kernel
from hannes.core.recording.recording import Recording
from hannes.identification.diagnosis.shape.likeliest import applicable
from hannes.identification.diagnosis.shape.shape import _table
from hannes.identification.shape_words import description_caution
from hannes.report.diagnosis import page

SIZE = 0.3  # N


@kernel
def sloped(size, position):
    """A rail that slopes the more the farther from its middle: outside what is known [N]."""
    return size * (position / 0.2) ** 2


SLOPED = effect("slope", sloped, 20.0, "N")


def found(hidden, describe=False):
    made = campaign(1, (hidden,))
    plant = Described()
    return diagnose(replace(made, plant=plant, shipped=plant), progress=False, describe=describe)


@pytest.fixture(scope="module")
def unknown():
    return found((SLOPED, SIZE), describe=True)


def test_the_shape_of_an_unknown_is_the_law_that_is_hidden(unknown):
    shape = unknown.verdict.shape
    assert unknown.verdict.verdict == "unknown" and shape["name"] == "generic_force"
    assert shape["closes"] > 0.8
    _places, low, high = (np.array(each) for each in (
        shape["axis"]["values"], shape["value"]["low"], shape["value"]["high"]))  # fmt: skip
    assert (low < high).all() and (shape["axis"]["unit"], shape["value"]["unit"]) == ("m", "N")
    json.loads(unknown.verdict.json())


def test_its_numbers_have_intervals_within_their_bounds(unknown):
    wide = _table(unknown.details.shape.described, 1e12)["parameters"]
    bounds = {p.name: p.bounds for p in PLACED.effect.parameters}
    assert {n: (each["low"], each["high"]) for n, each in wide.items()} == {
        PLACED.effect.full_name(name): each for name, each in bounds.items()
    }


def test_the_described_machine_follows_another_command(unknown):
    time, rng = np.arange(500) * 2e-3, np.random.default_rng(1)
    drive = 6.0 * np.sin(6.0 * time)
    another = Recording({"time": time, "drive": drive}, {n: UNITS[n] for n in ("time", "drive")})
    sled = Sled().with_effects(SLOPED)
    machine = {n: sled.parameters[n] * (1.0 + 0.02 * rng.standard_normal()) for n in Sled.uncertain}
    real = sled.simulate({**machine, "slope.size": SIZE}, another)["position"]
    off = [
        np.std(plant.simulate(dict(plant.parameters), another)["position"] - real)
        for plant in (unknown.details.plant, unknown.plant)
    ]
    assert off[1] < 0.2 * off[0]


def test_it_is_said_to_be_a_description_and_no_cause(unknown):
    assert any("generic_force, a law of free shape" in each for each in unknown.verdict.cautions)
    assert "is not its cause" in unknown.verdict.described
    text = page(unknown)
    assert 'id="shape"' in text and "generic_force" in text and "95 % band" in text
    assert unknown.verdict.described in unknown.verdict.summary()


def test_what_the_plant_has_already_is_not_fitted_again():
    """Its values are the machine's; from off it would be another one."""
    assert list(applicable(Described())) == ["generic_force"]
    assert applicable(Described().with_effects(PLACED.effect)) == {}


def test_nothing_is_described_where_an_effect_is_named():
    named = found((TURBULENCE, 2.0), describe=True)
    assert named.verdict.verdict == "named" and named.verdict.shape == {}
    assert "generic_force.c_0" not in named.plant.parameters
    assert "nothing is to be described: the verdict is named" in named.verdict.cautions


def test_where_none_was_fitted_it_does_not_say_that_none_helps():
    said = description_caution("unknown", {})
    assert "no generic disturbance was fitted" in said and "describes" not in said


def test_where_none_helps_it_says_so():
    result = found((GUST, 0.8), describe=True)
    assert result.verdict.verdict == "unknown" and result.verdict.shape["name"] == ""
    assert result.verdict.described.startswith(
        "No generic disturbance describes it: a force over the place on the rail: "
    )
    assert "generic_force.c_0" not in result.plant.parameters
    assert 'id="shape"' in page(result)
