"""What the page of kernel variables says may be read is what a run accepts, and no more."""

import pytest

from hannes.core.effect import Effect, Term
from hannes.core.parameter import Parameter
from hannes.plants.hand.plant import HandPlant
from hannes.plants.protocol import PLANTS, find_plant
from hannes.simulation.catalogue import effects
from hannes.simulation.compiler.open_channels import open_channels

HAND = {each.slot.name: each for each in open_channels(HandPlant.compiled_from)}


def reading(channel, names):
    kernel = eval(f"lambda {', '.join((*names, 'size'))}: 0.0")
    size = Parameter("size", 0.0, "1", (0.0, 1.0), "of it", off=0.0)
    return Effect("odd", "A test.", "-", "none", (size,), (Term(kernel, (channel,)),))


@pytest.mark.parametrize("plant", PLANTS)
def test_everything_listed_may_be_read_together(plant):
    found = find_plant(plant)
    listed = list(open_channels(found.compiled_from))
    assert listed
    for each in listed:
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
    listed = {*HAND[channel].arrays, *HAND[channel].numbers}
    assert known <= listed and not unknown & listed


def test_what_effects_of_the_package_write_and_read_is_listed():
    everywhere = {"t"} | {
        slot.name
        for layout in (HandPlant.compiled_from.parameters, HandPlant.compiled_from.states)
        for slot in layout.slots
    }
    for effect in effects().values():
        own = {each.name for each in (*effect.parameters, *effect.states)}
        for term in effect.terms:
            listed = {*HAND[term.writes[0]].arrays, *HAND[term.writes[0]].numbers}
            assert set(term.writes) <= HAND.keys()
            assert set(term.arguments) <= listed | everywhere | own, (effect.name, term)
