"""Faults of one finger: values of that finger, found by name like effects."""

import pickle

import pytest

from hannes.core.errors import BadInput
from hannes.plants.hand.finger_faults import FAULTS
from hannes.plants.hand.plant import HandPlant
from hannes.plants.part_fault import compiled_effects, like_faults, moved_by, part_faults
from hannes.simulation.catalogue import effects
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand


def test_every_finger_may_have_every_fault():
    kinds = {each.kind for each in FAULTS.values()}
    assert set(FAULTS) == {f"{finger}_{kind}" for finger in FINGERS for kind in kinds}
    assert len(kinds) == 4 and not FAULTS.keys() & effects().keys()


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_a_fault_moves_values_of_its_own_finger_alone(fault):
    parameters = Hand().parameters
    for amplitude in fault.amplitudes:
        assert amplitude.off == 0.0
        moves = moved_by(fault, amplitude.name)
        assert moves
        for name, change in moves.items():
            assert name.partition(".")[0] == fault.name.partition("_")[0]
            declared = parameters.declared[name]
            small = 0.1 * max(amplitude.bounds, key=abs)
            declared.check(parameters[name] + change * small)


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_a_fault_fits_a_terminal_and_is_pickled(fault):
    assert max(map(len, str(fault).splitlines())) <= 78
    assert pickle.loads(pickle.dumps(fault)) == fault and hash(fault) == hash(fault.name)


def test_faults_add_nothing_to_the_equations():
    hand, some = HandPlant(), tuple(FAULTS.values())[:3]
    assert compiled_effects((*some, effects()["capstan"])) == (effects()["capstan"],)
    assert FAULTS.items() <= hand.catalogue.items() and not any(map(hand.accepts, some))
    with pytest.raises(BadInput, match=r"index_weak_spring is a fault .* \[\[finger\]\]"):
        Hand().with_effects(FAULTS["index_weak_spring"])


def test_a_fault_takes_from_what_the_finger_has_for_itself():
    own = {"index.mcp_spring_stiffness": 0.6, "index.end_mcp": 0.9}
    known = HandPlant(Hand().with_values(own)).catalogue
    moves = moved_by(known["index_weak_spring"], "mcp_lost")
    assert moves == {"index.mcp_spring_stiffness": -0.6, "index.mcp_spring_preload": -1.0}
    stop = known["index_moved_stop"].parameters[0]
    travel = 0.9 - Hand().parameters["index.rest_mcp"]
    assert stop.bounds == (pytest.approx(-0.99 * travel), 0.3)
    shut = HandPlant(Hand().with_values({"index.end_mcp": -0.5})).catalogue
    assert shut["index_moved_stop"].parameters[0].bounds[0] == 0.0


def test_like_faults_are_those_of_other_fingers():
    known = {**effects(), **FAULTS}
    assert like_faults(known, "ring_moved_stop") == [
        f"{finger}_moved_stop" for finger in FINGERS if finger != "ring"
    ]
    assert like_faults(known, "capstan") == []
    assert part_faults(known, ["capstan", "thumb_weak_spring"]) == ["thumb_weak_spring"]
