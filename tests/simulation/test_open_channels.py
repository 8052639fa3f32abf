"""What the page of kernel variables says may be read is what a run accepts, and no more."""

import functools
from dataclasses import replace

import pytest

from hannes.core.effect import Effect, Term
from hannes.core.errors import BadInput
from hannes.core.layout import Layout
from hannes.core.parameter import Parameter
from hannes.plants.hand.plant import HandPlant
from hannes.plants.protocol import PLANTS, find_plant
from hannes.simulation.catalogue import effects
from hannes.simulation.compiler.expansion import opened
from hannes.simulation.compiler.open_channels import open_channels
from hannes.simulation.hand.model import EQUATIONS


@functools.cache
def listed(plant):
    """What the page lists of a plant, by name of the channel."""
    return {each.slot.name: each for each in open_channels(find_plant(plant).compiled_from)}


def reading(channel, names):
    kernel = eval(f"lambda {', '.join((*names, 'size'))}: 0.0")
    size = Parameter("size", 0.0, "1", (0.0, 1.0), "of it", off=0.0)
    return Effect("odd", "A test.", "-", "none", (size,), (Term(kernel, (channel,)),))


@pytest.mark.parametrize("plant", PLANTS)
def test_everything_listed_may_be_read_together(plant):
    found = find_plant(plant)
    assert listed(plant)
    for each in listed(plant).values():
        names = (*each.arrays, *each.numbers)
        assert len(set(names)) == len(names)
        assert found.accepts(reading(each.slot.name, names)) == ""


@pytest.mark.parametrize(
    ("channel", "known", "unknown"),
    [
        ("gear_friction", {"load", "excursion_rate", "leader_pull"}, {"tendon_tension", "voltage"}),
        ("spring_torque", {"stop_torque", "lane_angle"}, {"joint_torque", "penetration"}),
        ("normal_force", {"penetration", "slip_speed"}, {"drag", "torque_mcp"}),
        ("slack", {"excursion"}, {"leader_tension", "leader_pull"}),
    ],
)
def test_what_is_assigned_later_is_not_listed(channel, known, unknown):
    hand = listed("hand")
    names = {*hand[channel].arrays, *hand[channel].numbers}
    assert known <= names and not unknown & names


def test_what_effects_of_the_package_write_and_read_is_listed():
    hand = listed("hand")
    everywhere = {"t"} | {
        slot.name
        for layout in (HandPlant.compiled_from.parameters, HandPlant.compiled_from.states)
        for slot in layout.slots
    }
    for effect in effects().values():
        own = {each.name for each in (*effect.parameters, *effect.states)}
        for term in effect.terms:
            names = {*hand[term.writes[0]].arrays, *hand[term.writes[0]].numbers}
            assert set(term.writes) <= hand.keys()
            assert set(term.arguments) <= names | everywhere | own, (effect.name, term)


def test_a_variable_that_is_not_declared_is_no_interface():
    """A local variable of a stage can be read where the plant declares it, and else not."""
    bare = replace(EQUATIONS, numbers=Layout(()))
    effect = reading("gear_friction", ["load"])
    assert EQUATIONS.accepts(effect) == ""
    assert "load, which is a variable of gear alone" in bare.accepts(effect)


def test_an_opening_names_the_same_channels_twice():
    assert opened("    slack, supply = effects(slack, supply)") == ("    ", ["slack", "supply"])
    assert opened("    c.drag = effects(c.drag)") == ("    ", ["drag"])
    assert opened("    slack = effect(slack)") is None
    with pytest.raises(BadInput, match="both sides"):
        opened("    slack = effects(supply)")


def test_the_text_runs_as_plain_python():
    """Without effects an opening changes nothing."""
    from hannes.core.kernels.insertion import effects

    assert effects(1.5) == 1.5
    assert effects(1.5, 2.5) == (1.5, 2.5)
