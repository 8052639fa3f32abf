"""Settings that are other than stated: values of the hand, found by name like effects."""

import numpy as np
import pytest

from hannes.plants.hand.other_settings import other_settings
from hannes.plants.hand.plant import HandPlant
from hannes.plants.part_fault import compiled_effects, like_faults, moved_by, part_faults
from hannes.report.schematic_layout import parts_of
from hannes.simulation.catalogue import effects
from hannes.simulation.hand.hand import Hand

SETTINGS = other_settings(Hand().parameters)


@pytest.mark.parametrize("setting", SETTINGS.values(), ids=SETTINGS)
def test_a_setting_moves_values_that_the_hand_has(setting):
    parameters = Hand().parameters
    assert max(map(len, str(setting).splitlines())) <= 78
    for amplitude in setting.amplitudes:
        for name, change in moved_by(setting, amplitude.name).items():
            for end in amplitude.bounds:
                parameters.declared[name].check(parameters[name] + change * end)


def test_settings_add_nothing_to_the_equations_and_have_none_like_them():
    plant = HandPlant()
    assert SETTINGS.items() <= plant.catalogue.items()
    assert not SETTINGS.keys() & effects().keys()
    assert compiled_effects(tuple(SETTINGS.values())) == ()
    assert part_faults(plant.catalogue, SETTINGS) == []
    assert all(like_faults(plant.catalogue, name) == [] for name in SETTINGS)


def test_a_gain_is_a_share_of_the_stated_one():
    other = HandPlant(Hand().with_values({"position_pid.derivative": 4e-3}))
    moves = moved_by(other.catalogue["firmware_gains"], "derivative")
    assert moves == {"position_pid.derivative": pytest.approx(4e-3)}


def test_settings_sit_at_their_parts():
    assert parts_of(SETTINGS["firmware_gains"]) == ("controller",)
    assert parts_of(SETTINGS["mounting"]) == ()


@pytest.mark.parametrize("name", ["mounting.along_y", "firmware_gains.derivative"])
def test_a_setting_is_the_same_in_the_truth(name):
    from benchmarks.truth.parameters import NOMINAL, named
    from benchmarks.truth.settings import RANGES, changed

    setting, _, amplitude = name.partition(".")
    size = RANGES[name].high
    moved = moved_by(SETTINGS[setting], amplitude)
    mine = named({at: Hand().parameters[at] + by * size for at, by in moved.items()})
    theirs = changed(NOMINAL, name, size)
    assert all(np.allclose(value, theirs[at]) for at, value in mine.items())
    assert not all(np.allclose(value, NOMINAL[at]) for at, value in mine.items())


def test_the_limit_of_a_current_ranges_with_the_one_that_is_stated():
    for stated, bounds in ((4.0, (-3.9, 20.0)), (1.0, (-0.975, 5.0))):
        hand = HandPlant(Hand().with_values({"position_pid.limit": stated}))
        (change,) = hand.catalogue["current_limit"].parameters
        assert change.bounds == bounds
