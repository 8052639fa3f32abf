"""Experiments from TOML: what ships, sweeps and scatters, and texts that read back to the same."""

import numpy as np
import pytest

from hannes.core.errors import BadInput
from hannes.core.model import differences
from hannes.simulation.experiment import shipped
from hannes.simulation.experiment.friction_curve import FrictionCurve
from hannes.simulation.experiment.load import load, load_experiment, read
from hannes.simulation.experiment.reader import parse_experiment
from hannes.simulation.experiment.variants import MOST
from hannes.simulation.experiment.writer import experiment_toml
from hannes.simulation.hand.hand import Hand

HEAD = """
title = "mine"
duration = "0.5 s"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.3 s", "4 rad"]]
"""
BALL = '[object]\nshape = "sphere"\nradius = "30 mm"\n'


def variants(text):
    """What a text asks for, which is no friction curve."""
    found = read(HEAD + text, "mine.toml")
    assert isinstance(found, list)
    return found


@pytest.mark.parametrize("name", shipped.names())
def test_every_shipped_experiment_loads_and_says_what_it_asks(name):
    found = load(name)
    assert isinstance(found, FrictionCurve) or len({each.file for each in found}) == len(found) > 0
    assert shipped.question(shipped.find(name)).partition("?")[1] == "?"


@pytest.mark.parametrize("name", shipped.names())
def test_the_resolved_text_of_a_shipped_experiment_reads_back_to_it(name):
    found = load(name)
    if isinstance(found, FrictionCurve):
        pytest.skip("is not simulated")
    for each in found:
        (back,) = read(experiment_toml(each.hand, each.experiment), "resolved")
        assert dict(back.hand.parameters) == dict(each.hand.parameters)
        assert back.experiment.overrides() == each.experiment.overrides()
        assert np.array_equal(back.experiment.times, each.experiment.times)
        assert np.array_equal(back.experiment.reference.knots, each.experiment.reference.knots)
        assert back.experiment.noise == each.experiment.noise


def test_an_experiment_without_more_is_one_run_of_the_shipped_hand():
    (only,) = variants("")
    assert only.name == "" and only.file == "recording.h5"
    assert differences(only.hand) == {} and only.experiment.object is None
    assert (only.experiment.duration, only.experiment.sampling) == (0.5, 1000.0)
    assert only.experiment.controller == "continuous" and only.experiment.noise == {}


def test_hand_effects_and_values_are_those_of_the_text(tmp_path):
    (tmp_path / "hand.toml").write_text('[parameters]\n"motor.resistance" = "3.3 ohm"\n')
    text = 'hand = "hand.toml"\neffects = ["gear_load"]\n' + HEAD
    text += '[parameters]\n"gear_load.coefficient" = "0.05"\n"gravity.y" = "-9.81 m/s^2"\n'
    (only,) = read(text, "mine.toml", tmp_path)
    assert only.hand.parameters["motor.resistance"] == 3.3
    assert [each.name for each in only.hand.present_effects()] == ["gear_load"]
    assert only.experiment.values == {"gravity.y": -9.81}  # of the place, whichever hand is in it


def test_steps_hold_each_angle_until_the_next_time():
    (only,) = read(HEAD.replace('"ramp"', '"steps"'), "mine.toml")
    times, angles = only.experiment.reference.knots
    assert np.interp([0.0, 0.29, 0.31, 5.0], times, angles).tolist() == [0.0, 0.0, 4.0, 4.0]


def test_a_sweep_is_one_run_for_each_value_in_order():
    found = variants(BALL + '[sweep]\n"object.stiffness" = ["300 N/m", "2 kN/m"]\n')
    assert [each.name for each in found] == ["300 N/m", "2 kN/m"]
    assert [each.file for each in found] == ["recording-300-n-m.h5", "recording-2-kn-m.h5"]
    stiffness = [each.experiment.object.values["object.stiffness"] for each in found]
    assert stiffness == [300.0, 2000.0]


def test_a_sweep_to_either_side_of_zero_is_one_run_for_each():
    found = variants(BALL + '[sweep]\n"object.tilt_x" = ["-5 deg", "5 deg"]\n')
    assert [each.file for each in found] == ["recording-minus-5-deg.h5", "recording-5-deg.h5"]


def test_a_thin_prism_reads_back_from_the_text_that_is_written():
    thin = '[object]\nshape = "prism"\nsize = { width = "5 mm", height = "40 mm" }\n'
    (only,) = variants(thin)
    text = experiment_toml(only.hand, only.experiment)
    assert parse_experiment(text).object.values["object.radius"] == 2.5e-3


def test_a_sweep_over_several_is_over_their_product():
    text = '[sweep]\ncontroller = ["continuous", "sampled"]\n'
    text += '"motor.resistance" = ["3 ohm", "4 ohm", "5 ohm"]\n'
    found = variants(text)
    pairs = [
        (each.experiment.controller, each.hand.parameters["motor.resistance"]) for each in found
    ]
    assert pairs == [(c, r) for c in ("continuous", "sampled") for r in (3.0, 4.0, 5.0)]


def test_a_swept_place_keeps_the_other_coordinates():
    text = BALL + 'position = ["1 mm", "-46 mm", "2 mm"]\n[sweep]\n"object.x" = ["3 mm", "5 mm"]\n'
    for each, x in zip(variants(text), (3e-3, 5e-3), strict=True):
        values = each.experiment.object.values
        assert [values[f"object.{axis}"] for axis in "xyz"] == [x, -46e-3, 2e-3]


def test_variants_have_noise_of_their_own_that_the_seed_decides():
    text = (
        '[noise]\ncurrent = "10 mA"\nseed = {}\n[sweep]\n"motor.resistance" = ["3 ohm", "4 ohm"]\n'
    )
    seeds = [[each.experiment.seed for each in variants(text.format(seed))] for seed in (1, 1, 2)]
    assert seeds[0] == seeds[1] and not set(seeds[0]) & set(seeds[2])
    assert seeds[0][0] != seeds[0][1]


SCATTER = """
[scatter]
hands = {hands}
seed = {seed}
[scatter.spread]
"motor.resistance" = "0.05"
"motor.dry_friction" = "0.2"
"""


def test_a_scatter_draws_each_value_by_its_own_spread():
    found = variants(SCATTER.format(hands=200, seed=3))
    assert found[0].name == "virtual hand 1" and found[0].file == "recording-virtual-hand-1.h5"
    for name, spread in (("motor.resistance", 0.05), ("motor.dry_friction", 0.2)):
        drawn = np.log([each.hand.parameters[name] / Hand().parameters[name] for each in found])
        assert drawn.std() == pytest.approx(spread, rel=0.2)
        assert abs(drawn.mean()) < 3.0 * spread / np.sqrt(200)
    assert set(differences(found[0].hand)) == {"motor.resistance", "motor.dry_friction"}


def test_a_virtual_hand_depends_on_the_seed_and_its_number_alone():
    few, many, other = (
        [dict(each.hand.parameters) for each in variants(SCATTER.format(hands=n, seed=seed))]
        for n, seed in ((2, 3), (5, 3), (2, 4))
    )
    assert few == many[:2] and few != other and few[0] != few[1]


def test_scattered_values_stay_inside_their_bounds():
    wide = SCATTER.format(hands=200, seed=1).replace('"0.2"', '"1"')
    for each in variants(wide):
        for name, value in each.hand.parameters.items():
            each.hand.parameters.declared[name].check(value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[sweep]\n"motor.resistance" = []\n', "makes 0 variants"),
        ('[sweep]\n"motor.resistance" = ["3 ohm", "3 ohm"]\n', "gives the same value twice"),
        ('[sweep]\n"motor.resistanse" = ["3 ohm"]\n', 'did you mean "motor.resistance"'),
        ('[sweep]\n"motor.resistance" = ["3 m"]\n', "not a resistance"),
        ('[sweep]\n"motor.resistance" = "3 ohm"\n', "must be a list"),
        ('[sweep]\n"object.stiffness" = ["3 N/m"]\n', "cannot be swept: the experiment has no"),
        ('[sweep]\ncontroller = ["samplet"]\n', 'did you mean "sampled"'),
        ('[sweep]\n"leader_slack.length" = ["1 mm"]\n', "belongs to an effect that is not on"),
        (SCATTER.format(hands=0, seed=1), "whole number from 1"),
        (SCATTER.format(hands=MOST + 1, seed=1), f"to {MOST}"),
        (SCATTER.format(hands=1, seed=-1), "whole number from 0"),
        ("[scatter]\nhands = 2\n", "scatter.spread is missing"),
        ('[scatter]\nhands = 2\n[scatter.spread]\n"gravity.x" = "0.1"\n', "is zero in this hand"),
        ('[scatter]\nhands = 2\n[scatter.spread]\n"motor.resistance" = "2"\n', "from 0 to 1"),
        (SCATTER.format(hands=2, seed=1) + '[sweep]\ncontroller = ["sampled"]\n', "beside"),
        ("[objects]\n", 'did you mean "object"'),
        ('[object]\nshape = "cube"\n', 'object.shape = "cube"'),
        ('[object]\nshape = "sphere"\nsize = {}\n', 'belongs to shape = "prism"'),
        (BALL + '[parameters]\n"object.radius" = "3 cm"\n', "is given in .object. too"),
        ('[noise]\ncurrent = "-1 mA"\n', "not negative"),
    ],
)
def test_a_bad_sweep_scatter_or_object_is_one_line(text, said):
    with pytest.raises(BadInput, match=said) as caught:
        variants(text)
    assert str(caught.value).startswith("mine.toml: ") and "\n" not in str(caught.value)


def test_a_friction_curve_is_no_simulation():
    with pytest.raises(BadInput, match="needs no simulation; see it with `hannes run"):
        load_experiment("friction-curve")
    with pytest.raises(BadInput, match='unknown key "duration"'):
        read(HEAD.replace('"mine"', '"mine"\nkind = "friction-curve"'), "mine.toml")
