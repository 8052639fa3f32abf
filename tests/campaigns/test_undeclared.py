"""Channels that a plant does not have are left out, and said; misspelt ones are refused."""

import numpy as np
import pytest

from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.check import check
from hannes.campaigns.quality.finding import KINDS
from hannes.campaigns.undeclared import said, undeclared, without
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.plants.axis.plant import Axis

TIME = np.linspace(0.0, 1.0, 1001)
SOUND = {"reference": 0.01 * TIME, "position": 0.01 * TIME, "drive": 0.0 * TIME}
UNITS = {"time": "s", "reference": "m", "position": "m", "drive": "V"}


def recorded(**more):
    """A recording of the axis with further channels, in V."""
    added = {name: np.sin(TIME) for name in more}
    return Recording({"time": TIME, **SOUND, **added}, {**UNITS, **more})


def test_others_are_left_out_and_misspelt_ones_are_not():
    assert undeclared(recorded(), Axis()) == ()
    assert undeclared(recorded(lamp="V", motor_position="m"), Axis()) == ("lamp",)
    assert without(recorded(lamp="V"), ("lamp",)) == recorded()


def test_check_says_so_and_finds_nothing_else():
    lit, plain = (check(each, Axis()) for each in (recorded(lamp="V"), recorded()))
    assert [each for each in lit if each.channel != "lamp"] == plain
    (other,) = [each for each in lit if each.channel == "lamp"]
    assert other.level == "note" and "left out" in str(other) and other.kind in KINDS


def test_a_campaign_has_the_channels_of_its_plant(tmp_path):
    file = tmp_path / "campaign.toml"
    file.write_text('plant = "axis"\n[[recording]]\nfile = "run.csv"\n', encoding="utf-8")
    recorded(lamp="V").write(tmp_path / "run.csv")
    (entry,) = read_campaign(file).entries
    assert entry.recording == recorded() and entry.left_out == ("lamp",)
    assert said(entry.left_out, Axis()).endswith("the plant axis has no such channel: lamp")
    recorded(positon="m").write(tmp_path / "run.csv")
    with pytest.raises(BadInput, match='did you mean "position"'):
        read_campaign(file)
