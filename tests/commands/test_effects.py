"""`hannes effects FILE:NAME` refuses what a run would refuse, in one line."""

import pytest
from own_effect import EFFECT

from hannes.commands.cli import main

CODE = "@kernel\ndef rub({arguments}):\n    return {returned}\n"
REFUSED = {
    "a channel that does not exist": (
        {"writes": "gear_frictoin"},
        'does not fit the plant "hand": it needs a channel gear_frictoin, which this plant does '
        'not have; did you mean "gear_friction"?; if it is for another plant',
    ),
    "a quantity that does not exist": (
        {"arguments": "motor_sped, size"},
        'does not have; did you mean "motor_speed"?',
    ),
    "a quantity that is filled later": (
        {"arguments": "joint_torque, size", "writes": "spring_torque"},
        "is not yet assigned where spring_torque is open",
    ),
    "an undefined name": ({"returned": "size * nowhere"}, "cannot be compiled: NameError"),
    "two values for one channel": (
        {"returned": "size, motor_speed"},
        "kernel rub returns 2 values: expected 1, for gear_friction",
    ),
    "no value": ({"returned": "None"}, "kernel rub returns none for gear_friction"),
    "an array where a number is due": (
        {"arguments": "leader_pull, size", "returned": "size * leader_pull"},
        "for gear_friction: expected a number",
    ),
    "more than nothing at off": ({"returned": "motor_speed"}, "expected exactly 0"),
    "no number at off": ({"returned": "0.0 / size"}, "adds nan to gear_friction"),
    "an element that is not there": (
        {"arguments": "leader_pull, size", "returned": "size * leader_pull[9]"},
        "kernel rub reads beyond an array: index 9",
    ),
    "the name of one that ships": ({"name": "leader_slack"}, "one that ships has this name"),
    "a name that is none": ({"name": "my effect"}, "expected a name of letters, digits and _"),
    "channels as one text": ({"writes": "gear_friction", "tuple_end": ""}, 'in a tuple, ("a",)'),
    "a plain function": ({"mark": ""}, "kernel rub is a plain function: mark it @kernel"),
}


def written(folder, mark="@kernel\n", arguments="motor_speed, size", returned="size * motor_speed",
            writes="gear_friction", name="mine", tuple_end=","):  # fmt: skip
    """An effect's file with one fault or none; returns what to type."""
    code = f"{mark}def rub({arguments}):\n    return {returned} + 0.0 * size\n"
    if "," in returned or returned == "None":
        code = f"{mark}def rub({arguments}):\n    x = size\n    return {returned}\n"
    text = EFFECT.format(code=code).replace('"gear_friction",', f'"{writes}"{tuple_end}')
    text = text.replace('"mine"', f'"{name}"')
    (folder / "mine.py").write_text(text, encoding="utf-8")
    return f"{folder / 'mine.py'}:EFFECT"


@pytest.mark.parametrize("fault", REFUSED)
def test_what_a_run_would_refuse_is_refused(tmp_path, capsys, compiling, fault):
    change, said = REFUSED[fault]
    assert main(["effects", written(tmp_path, **change)]) == 2
    printed = capsys.readouterr()
    assert said in printed.err and printed.out == ""
    assert printed.err.count("\n") == 1 and printed.err.startswith("hannes: ")


def test_a_kernel_that_changes_what_it_reads_is_refused(tmp_path, capsys, compiling):
    typed = written(tmp_path, arguments="leader_pull, size", returned="size * leader_pull[0]")
    file = tmp_path / "mine.py"
    changed = file.read_text().replace("    return", "    leader_pull[0] = 0.0\n    return")
    file.write_text(changed, encoding="utf-8")
    assert main(["effects", typed]) == 2
    assert "changes leader_pull, which it may only read" in capsys.readouterr().err


def test_an_effect_that_a_run_would_take_is_described(tmp_path, capsys):
    assert main(["effects", written(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("mine\n  A test.\n")


def test_an_array_may_be_read_where_the_kernel_makes_a_number_of_it(tmp_path, capsys):
    sound = written(tmp_path, arguments="leader_pull, size", returned="size * leader_pull[0]")
    assert main(["effects", sound]) == 0


def test_an_effect_is_judged_for_the_plant_that_it_is_for(tmp_path, capsys):
    slack = written(tmp_path, arguments="size", returned="size", writes="slack")
    assert main(["effects", slack]) == 0
    assert main(["effects", slack, "--plant", "axis"]) == 2
    assert 'does not fit the plant "axis": it needs a channel slack' in capsys.readouterr().err
    cart = "examples/own_plant/rail.py:RAIL_FRICTION"
    assert main(["effects", cart]) == 2
    assert "if it is for another plant, name that with --plant" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["leader_slack", "gear_load"])
def test_effects_that_ship_are_described_with_what_they_are_confused_with(capsys, name):
    assert main(["effects", name]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith(f"{name}\n") and "easily confused with" in shown


def test_what_a_diagnosis_of_the_hand_names_is_described(capsys):
    assert main(["effects", "index_weak_spring"]) == 0
    assert "index.mcp_spring_stiffness" in capsys.readouterr().out
    assert main(["effects", "index_weak_sprig"]) == 2


def test_of_another_plant_an_effect_has_that_machines_bounds(capsys):
    assert main(["effects", "warming_grease", "--plant", "axis"]) == 0
    assert "0 to 0.2, vanishes at 0" in capsys.readouterr().out


def test_all_that_ship_are_listed(capsys):
    from hannes import effects

    assert main(["effects"]) == 0
    assert [line for line in capsys.readouterr().out.splitlines() if line[0] != " "] == [*effects()]
    assert main(["effects", "--plant", "axis"]) == 0
    assert capsys.readouterr().out.startswith("slow_friction\n")


def test_all_effects_of_the_package_pass_the_check(compiling):
    from hannes import effects
    from hannes.plants.hand.plant import HandPlant
    from hannes.simulation.compiler.kernel_check import check_kernels

    for effect in effects().values():
        assert HandPlant().accepts(effect) == ""
        check_kernels(HandPlant.compiled_from, effect)
