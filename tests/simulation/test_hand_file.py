"""hand.toml, of the hand and any other plant: read, written, printed, refused in one line."""

import pytest
from own_effect import EFFECT
from sled import PLACED, Described

from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.core.model import differences
from hannes.plants.axis.plant import Axis
from hannes.plants.plant_file import load_model, plant_toml, with_plant_file
from hannes.simulation.catalogue import effect
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import DEEPEST, hand_toml, load_hand

LOOSE = """\
base = "hannes"
effects = ["leader_slack"]
[parameters]
"leader_slack.length" = "3.1 mm"
"motor.resistance" = "3.2 ohm"
"""


def written(folder, text, name="hand.toml"):
    """Path of a file with this text."""
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def test_a_hand_holds_what_its_file_says(tmp_path):
    hand = load_hand(written(tmp_path, LOOSE))
    assert [each.name for each in hand.effects] == ["leader_slack"]
    assert differences(hand) == {"leader_slack.length": 3.1e-3, "motor.resistance": 3.2}


def test_what_is_written_reads_back_to_the_same_hand(tmp_path):
    hand = Hand().with_effects("gear_load", "leader_slack")
    hand = hand.with_values({"gear_load.coefficient": 0.1 / 3.0, "little.rest_mcp": 0.2})
    back = load_hand(written(tmp_path, hand_toml(hand)))
    assert back.effects == hand.effects and dict(back.parameters) == dict(hand.parameters)


def test_files_build_on_one_another_relative_to_themselves(tmp_path):
    (tmp_path / "lower").mkdir()
    written(tmp_path / "lower", LOOSE)
    top = written(tmp_path, 'base = "lower/hand.toml"\n[parameters]\n"motor.resistance" = "4 ohm"')
    assert differences(load_hand(top)) == {"leader_slack.length": 3.1e-3, "motor.resistance": 4.0}


def test_files_that_build_on_one_another_in_a_circle_are_refused(tmp_path):
    file = written(tmp_path, 'base = "hand.toml"')
    with pytest.raises(BadInput, match=f"more than {DEEPEST} hand files"):
        load_hand(file)


def test_two_effects_of_one_name_are_refused(tmp_path):
    text = "from dataclasses import replace\nfrom hannes.dynamics.capstan import EFFECT\n"
    written(tmp_path, text + 'MINE = replace(EFFECT, meaning="another")\n', "mine.py")
    with pytest.raises(BadInput, match='another effect has the name "capstan"'):
        load_hand(written(tmp_path, 'effects = ["capstan", "mine.py:MINE"]'), trust=True)


def test_an_effect_of_the_users_own_is_found_again(tmp_path):
    code = "@kernel\ndef rub(motor_speed, size):\n    return size * motor_speed\n"
    written(tmp_path, EFFECT.format(code=code), "mine.py")
    hand = load_hand(written(tmp_path, 'effects = ["mine.py:EFFECT"]'), trust=True)
    assert f'"{tmp_path / "mine.py"}:EFFECT"' in hand_toml(hand)
    (tmp_path / "elsewhere").mkdir()
    near = hand_toml(hand, folder=tmp_path / "elsewhere")
    assert '"../mine.py:EFFECT"' in near
    back = load_hand(written(tmp_path / "elsewhere", near), trust=True)
    assert back.effects == hand.effects


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("base = ", "is not valid TOML"),
        ("bse = 'hannes'", 'unknown key "bse"; did you mean "base"?'),
        ('base = "hanes"', 'base = "hanes": expected hannes.*did you mean "hannes"'),
        ('base = "axis"', "values of another plant.*`hannes hand` prints them"),
        ('effects = "leader_slack"', "effects must be a list"),
        ('effects = ["leader_slak"]', 'did you mean "leader_slack"'),
        ("parameters = 3", "must be a table"),
        ('[parameters]\n"motor.resistanse" = "3 ohm"', 'did you mean "motor.resistance"'),
        ('[parameters]\n"motor.resistance" = "3 m"', "motor.resistance.*not a resistance"),
        ('[parameters]\n"motor.resistance" = 3', "has no unit"),
        ('[parameters]\n"motor.resistance" = "-3 ohm"', "below its lower bound"),
        ('[parameters]\n"leader_slack.length" = "1 mm"', 'add effects = ."leader_slack".'),
        ('[parameters]\n"controller.sampled" = "1"', "in the experiment"),
    ],
)
def test_a_bad_hand_file_is_one_line_with_its_name(tmp_path, text, said):
    file = written(tmp_path, text)
    with pytest.raises(BadInput, match=said) as caught:
        load_hand(file)
    assert str(caught.value).startswith(str(file)) and "\n" not in str(caught.value)


def test_a_name_that_is_no_hand():
    with pytest.raises(BadInput, match=r'no hand named "hanes"; did you mean "hannes"'):
        load_hand("hanes")


def rubbing():
    """The axis with an effect and another mass."""
    axis = Axis().with_effects(effect("direction_friction"))
    return axis.with_values({"direction_friction.viscous": -0.18, "axis.mass": 95.5})


def test_the_file_of_another_plant_names_it(tmp_path):
    file = written(tmp_path, plant_toml(rubbing(), Axis(), "axis"))
    found = load_model(str(file))
    assert isinstance(found, Axis) and found.effects == rubbing().effects
    assert dict(found.parameters) == dict(rubbing().parameters)


def test_an_effect_within_a_machines_own_range_is_found_again(tmp_path):
    axis = Axis().with_effects(effect("warming_grease"))
    axis = axis.with_values({"warming_grease.fall": 0.1})
    assert axis.effects != (effect("warming_grease"),)
    file = written(tmp_path, plant_toml(axis, Axis(), "axis"))
    top = written(tmp_path, f'base = "{file.name}"\neffects = ["warming_grease"]', "top.toml")
    for each in (file, top):
        found = load_model(str(each))
        assert found.effects == axis.effects
        assert dict(found.parameters) == dict(axis.parameters)


def test_a_generic_disturbance_of_a_plant_of_ones_own_is_found_again(tmp_path):
    described = Described().with_effects(PLACED.effect).with_values({"generic_force.c_1": 0.3})
    file = written(tmp_path, plant_toml(described, Described(), "sled"))
    back = with_plant_file(Described(), file, "sled")
    assert back.effects == described.effects
    assert back.parameters["generic_force.c_1"] == 0.3


def test_only_what_differs_from_the_given_plant_is_written(tmp_path):
    """A user's own plant may start elsewhere than at the declared values."""
    given = Axis().with_values({"axis.mass": 95.5, "axis.offset": -2.0})
    moved = given.with_values({"axis.offset": -3.1648})  # the declared value, not the given one
    text = plant_toml(moved, given, "axis")
    assert '"axis.offset"' in text and "axis.mass" not in text
    back = with_plant_file(given, written(tmp_path, text), "axis")
    assert dict(back.parameters) == dict(moved.parameters)


def test_hand_prints_the_file_of_another_plant(tmp_path, capsys):
    file = written(tmp_path, plant_toml(rubbing(), Axis(), "axis"))
    assert main(["hand", str(file)]) == 0
    printed = capsys.readouterr().out
    assert 'The plant "axis"' in printed and "direction_friction.viscous = -0.18" in printed
    assert main(["hand", str(file), "--equations"]) == 0
    assert "direction_friction__asymmetry(" in capsys.readouterr().out
    assert main(["hand", str(file), "--values"]) == 0
    assert "here, not 95.109" in capsys.readouterr().out


EXPERIMENT = """\
hand = "hand.toml"
duration = "10 ms"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["1 s", "15 rad"]]
"""


def test_run_says_what_a_hand_file_is_for(tmp_path, capsys):
    file = written(tmp_path, plant_toml(rubbing(), Axis(), "axis"))
    assert main(["run", str(file)]) == 2
    assert 'an experiment names it: hand = "hand.toml"' in capsys.readouterr().err
    assert main(["run", str(written(tmp_path, EXPERIMENT, "my.toml"))]) == 2
    line = capsys.readouterr().err
    assert "my.toml: hand = " in line and "values of another plant" in line


FINGERS = """\
[parameters]
"mcp.moment_arm" = "9 mm"
[[finger]]
name = "index"
mcp_moment_arm = "9.9 mm"
pip_spring_stiffness = "70 %"
pip_coulomb_friction = "150 %"
[[finger]]
name = "thumb"
end_mcp = "1 rad"
"""


def test_a_finger_has_values_of_its_own(tmp_path):
    hand = load_hand(written(tmp_path, FINGERS))
    assert differences(hand) == pytest.approx(
        {
            "mcp.moment_arm": 9e-3,
            "index.mcp_moment_arm": 1.1,
            "index.pip_spring_stiffness": 0.7,
            "index.pip_coulomb_friction": 1.5,
            "thumb.end_mcp": 1.0,
        }
    )
    back = load_hand(written(tmp_path, hand_toml(hand), "again.toml"))
    assert dict(back.parameters) == dict(hand.parameters)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[[finger]]\nname = 'indx'", 'expected one of index.*did you mean "index"'),
        ("[[finger]]\nmcp_moment_arm = '1'", "name is missing"),
        ("[[finger]]\nname = 'index'\nmcp_moment_am = '1'", 'did you mean "mcp_moment_arm"'),
        ("[[finger]]\nname = 'index'\nmcp_moment_arm = '3 N'", "mcp_moment_arm.*length"),
        ("[[finger]]\nname = 'index'\nmcp_moment_arm = '-20 %'", "below its lower bound"),
        ("[[finger]]\nname = 'index'\npip_moment_arm = '90 %'\n" * 2, "given twice"),
        ("[[finger]]\nname = 'index'\npip_moment_arm = 0.0104", "has no unit"),
        ("[[finger]]\nname = 'index'\npip_moment_arm = '0.0104'", "has no unit"),
        ("finger = 1", "list"),
        ("finger = [1]", "must be tables"),
    ],
)
def test_fingers_that_make_no_sense_are_refused(tmp_path, text, why):
    with pytest.raises(BadInput, match=why):
        load_hand(written(tmp_path, text))


def test_a_plant_without_fingers_takes_none(tmp_path):
    file = written(tmp_path, 'base = "axis"\n[[finger]]\nname = "index"\n')
    with pytest.raises(BadInput, match="belongs to a hand"):
        load_model(str(file))
