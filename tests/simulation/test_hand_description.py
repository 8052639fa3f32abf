"""What `print(hand)` and `hannes hand` show: stages, effects in their place, changes, sources."""

import re

import pytest

from hannes.core.errors import BadInput
from hannes.plants.axis.plant import Axis
from hannes.simulation.catalogue import effects
from hannes.simulation.hand.description import (
    COLUMNS,
    equations_of,
    plant_described,
    value_table,
)
from hannes.simulation.hand.hand import Hand

STAGES = (
    *("reference", "sense", "control", "drive", "kinematics", "leader", "gear", "carts", "joints"),
    *("contact", "inertia"),
)


def section(text, title):
    """Lines of one section, without its title."""
    rest = text.split(f"\n{title}", 1)[1]
    return rest.split("\n\n", 1)[0].splitlines()[1:]


def test_print_shows_the_stages_in_the_order_of_the_equations():
    text = str(Hand())
    assert text == str(Hand())
    shown = [line.split()[0] for line in section(text, "Stages") if re.match(r"  \w", line)]
    assert tuple(shown) == STAGES
    for formula in ("eq. 1", "eq. 2", "eq. 3", "m_c x'' = 2 T_L - 2 T_F - F(x')"):
        assert formula in text


def test_nothing_is_wider_than_a_terminal():
    everything = Hand().with_effects(*effects())
    values = {p.name: p.bounds[1] for p in everything.parameters.declared.values() if "." in p.name}
    loud = everything.with_values({n: x for n, x in values.items() if n.split(".")[0] in effects()})
    for hand in (Hand(), everything, loud):
        assert max(map(len, str(hand).splitlines())) <= COLUMNS


@pytest.mark.parametrize(
    ("name", "stage", "value"),
    [
        ("leader_slack", "leader", {"leader_slack.length": 3e-3}),
        ("gear_load", "gear", {"gear_load.coefficient": 0.05}),
    ],
)
def test_an_effect_stands_in_the_stage_that_it_joins(name, stage, value):
    text = str(Hand().with_effects(name).with_values(value))
    lines = section(text, "Stages")
    start = next(k for k, line in enumerate(lines) if line.startswith(f"  {stage} "))
    end = next(k for k in range(start + 1, len(lines)) if re.match(r"  \w", lines[k]))
    assert f"+ effect {name}" in "\n".join(lines[start:end])
    effect = "\n".join(section(text, "Effects"))
    assert name in effect and effects()[name].equation in effect and "source: " in effect
    assert "off" not in effect


def test_an_effect_that_is_off_says_so():
    text = str(Hand().with_effects("leader_slack"))
    assert "leader_slack (off" in text and "+ effect leader_slack" not in text


def test_changed_values_stand_beside_the_shipped_ones():
    assert section(str(Hand()), "Values that differ") == ["  none"]
    hand = Hand().with_values({"motor.resistance": 4.2})
    shipped = Hand().parameters["motor.resistance"]
    (line,) = section(str(hand), "Values that differ")
    assert line == f"  motor.resistance = 4.2 ohm  (shipped: {shipped:.6g})"


def test_every_value_has_its_unit_meaning_and_source():
    lines = value_table(Hand()).splitlines()
    every = Hand().parameters.declared
    declared = {name: each for name, each in every.items() if not each.shared}
    values = [line for line in lines if line.startswith("  ")]
    assert len(values) == len(declared)
    for line, (name, each) in zip(values, declared.items(), strict=True):
        assert line.split()[0] == name.partition(".")[2]
        assert each.doc in line and f"({each.source})" in line and f" {each.unit} " in line


def test_values_without_a_published_source_are_called_a_choice():
    sources = section(str(Hand()), "Sources")
    declared = Hand().parameters.declared.values()
    chosen = [each for each in declared if each.source.startswith("choice") and not each.shared]
    assert sources[-1] == f"  choice, no published value: the other {len(chosen)}"
    assert any("gear.ratio" in line for line in sources)


def test_another_plant_is_described_by_effects_and_values():
    axis = Axis().with_effects(effects()["direction_friction"]).with_values({"axis.mass": 96.5})
    text = plant_described(axis, "axis")
    assert "axis.mass = 96.5 kg" in text and "direction_friction (off" in text
    for name in axis.parameters:
        assert f"  {name.partition('.')[2]} " in text


def test_equations_are_printed_or_refused():
    hand = Hand().with_effects("leader_slack").with_values({"leader_slack.length": 1e-3})
    assert "leader_slack__free_length(" in equations_of(hand)

    class Bare(Axis):
        equations = None

    with pytest.raises(BadInput, match="leave out --equations"):
        equations_of(Bare())
