"""Campaigns: what they hold, how roles are drawn, and one line for whatever cannot be used."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.campaign_file import campaign_file, read_campaign
from hannes.campaigns.roles import with_roles
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.experiment.reader import experiment_text

TIME = np.arange(0.0, 0.4, 2e-3)


def recording(**changes):
    """A short recording of the hand; `changes` are further fields, or channels left out."""
    channels = {"time": TIME, "reference": 15.0 * TIME, "position": 14.0 * TIME}
    channels["current"] = 0.3 + 0.0 * TIME
    for name in changes.pop("without", ()):
        del channels[name]
    units = {"time": "s", "reference": "rad", "position": "rad", "current": "A"}
    return Recording(channels, {name: units[name] for name in channels}, plant="hand", **changes)


def campaign(folder, text, **files):
    """Path of a campaign beside recordings r.h5 and others by name."""
    for name, each in {"r": recording(), **files}.items():
        each.write(folder / f"{name}.h5")
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder / "campaign.toml"


ROW = '[[recording]]\nfile = "r.h5"\n'


def test_a_campaign_in_full(tmp_path):
    (tmp_path / "hand.toml").write_text('[parameters]\n"motor.resistance" = "3.3 ohm"\n')
    text = """
title = "Two repeats"
plant = "hand"
base = "hand.toml"
out = "elsewhere"
[[recording]]
file = "void_*.h5"
experiment = "void-closure"
condition = "void"
role = "fit"
[[recording]]
file = "r.h5"
role = "show"
"""
    found = read_campaign(campaign(tmp_path, text, void_2=recording(), void_1=recording()))
    assert [each.name for each in found.entries] == ["void_1.h5", "void_2.h5", "r.h5"]
    assert [each.condition for each in found.entries] == ["void", "void", "r.h5"]
    assert [each.name for each in found.of("show")] == ["r.h5"]
    assert found.entries[0].recording.experiment == experiment_text("void-closure")
    assert (found.title, str(found.out), found.base) == ("Two repeats", "elsewhere", "hannes")
    assert found.plant.parameters["motor.resistance"] == 3.3
    assert found.shipped.parameters["motor.resistance"] != 3.3
    assert {"leader_slack", "gear_load"} <= set(found.effects)


def test_a_folder_for_each_run_makes_no_repeats_and_keeps_their_order(tmp_path):
    for number in (10, 9):
        (tmp_path / f"run {number}").mkdir()
        recording().write(tmp_path / f"run {number}" / "log.h5")
    found = read_campaign(campaign(tmp_path, '[[recording]]\nfile = "*/log.h5"\n')).entries
    assert [each.name for each in found] == ["run 9/log.h5", "run 10/log.h5"]
    assert [each.condition for each in found] == ["run 9/log.h5", "run 10/log.h5"]
    assert [each.number for each in found] == [0, 1]


def test_a_recording_is_not_taken_twice_by_two_spellings(tmp_path):
    rows = [f'[[recording]]\nfile = "{name}"\n' for name in ("r.h5", "../here/r.h5")]
    (tmp_path / "here").mkdir()
    with pytest.raises(BadInput, match=r'lists "\.\./here/r\.h5" twice'):
        read_campaign(campaign(tmp_path / "here", "".join(rows)))


def test_runs_are_numbered_where_a_campaign_is_made_by_hand():
    plant = HandPlant()
    made = Campaign(plant, plant, tuple(entries(void=3)), Path("out"), {})
    assert [each.number for each in made.entries] == [0, 1, 2]


def test_what_is_simulated_keeps_how_its_object_moves(tmp_path):
    text = '[[recording]]\nfile = "simulated:floating-cylinder"\n'
    with pytest.raises(BadInput, match="by which its object moves"):
        read_campaign(campaign(tmp_path, text))


def test_a_seed_below_zero_is_refused(tmp_path):
    with pytest.raises(BadInput, match="seed = -1"):
        read_campaign(campaign(tmp_path, ROW), seed=-1)


def entries(**conditions):
    """Entries without role: so many of each condition."""
    return [
        Entry(f"{name}_{k}", recording(), name) for name, n in conditions.items() for k in range(n)
    ]


@pytest.mark.parametrize(
    ("count", "shares"),
    [
        (1, {"fit": 1}),
        (2, {"fit": 1, "show": 1}),
        (3, {"fit": 1, "select": 1, "show": 1}),
        (6, {"fit": 3, "select": 2, "show": 1}),
        (12, {"fit": 6, "select": 3, "show": 3}),
    ],
)
def test_roles_are_shared_out(count, shares):
    assert Counter(each.role for each in with_roles(entries(void=count), 0)) == shares


def test_every_condition_gets_every_role():
    found = with_roles(entries(slow=4, fast=8), 3)
    for name in ("slow", "fast"):
        assert {each.role for each in found if each.condition == name} == {"fit", "select", "show"}


def test_roles_follow_the_seed_and_leave_given_ones():
    given = [*entries(void=8), Entry("mine", recording(), "void", "show")]
    first, again, other = (with_roles(given, seed) for seed in (1, 1, 2))
    assert first == again != other
    assert all(found[-1].role == "show" for found in (first, other))


def test_a_shipped_campaign_is_found_by_name():
    assert campaign_file("emps").name == "emps.toml"
    with pytest.raises(BadInput, match=r'no campaign named "empps"; did you mean "emps"'):
        campaign_file("empps")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "recording is missing: expected .*file = "),
        ("recording = 3", "recording must be a list"),
        ("plant = ", "is not valid TOML"),
        ("plnt = 'hand'\n" + ROW, 'unknown key "plnt"; did you mean "plant"'),
        ("plant = 3\n" + ROW, "plant must be text"),
        ("plant = 'hnd'\n" + ROW, 'plant = "hnd": unknown plant "hnd"; did you mean "hand"'),
        ("plant = 'no.where:Plant'\n" + ROW, "no.where:Plant cannot be loaded"),
        ("plant = 'axis'\n" + ROW, "r.h5: a recording of the plant .hand., not of .axis."),
        ("base = 'r.toml'\n" + ROW, "base = .*r.toml: there is no such file; did you mean"),
        ("effects = ['mine.py:E']\n" + ROW, "effects cannot be used: cannot read "),
        ("[[recording]]", "recording 1.file is missing"),
        (ROW + "roll = 'fit'", 'unknown key "recording 1.roll"; did you mean "role"'),
        (ROW + "role = 'fitt'", 'recording 1.role = "fitt": .*did you mean "fit"'),
        (ROW + "mapping = 'm.toml'", "recording 1.mapping cannot be used: .*m.toml"),
        (ROW + "mapping = ''", "recording 1.mapping cannot be used: "),
        (
            "[[recording]]\nfile = 'simulated:x.toml'\nmapping = 'emps'",
            "this recording is simulated",
        ),
        (ROW + "experiment = 'void'", "recording 1.experiment cannot be used: no experiment"),
        (ROW + "[[recording]]\nfile = 'q.h5'", "recording 2.file = .*q.h5: there is no such file"),
        ("[[recording]]\nfile = 'v_*.h5'", 'recording 1.file = "v_\\*.h5" matches no file'),
        ("[[recording]]\nfile = '.'", "a folder; expected a file"),
        ("[[recording]]\nfile = '**.h5'", "recording 1.file cannot be used: .* no pattern"),
        (ROW + "runs = '::00'", 'recording 1.runs = "::00": expected start:stop:step'),
        ("[[recording]]\nfile = '*.h5'\n" + ROW + "role = 'show'", 'recording lists "r.h5" twice'),
        ("effects = ['generic_easing']\n" + ROW, '"generic_easing" describes and names no cause'),
        ("effects = ['own.py:MINE']\n" + ROW, 'two effects have the name "capstan": rename'),
    ],
)
def test_a_bad_campaign_is_one_line_with_its_name(tmp_path, text, said):
    file = campaign(tmp_path, text)
    mine = "from dataclasses import replace\nfrom hannes.dynamics.capstan import EFFECT\n"
    (tmp_path / "own.py").write_text(mine + "MINE = replace(EFFECT, source='mine')\n")
    with pytest.raises(BadInput, match=said) as caught:
        read_campaign(file, trust=True)
    assert str(tmp_path) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("spoilt", "said"),
    [
        (recording(without=["reference"]), "neither a channel reference_rad nor an experiment"),
        (recording(experiment="duration = "), "experiment: is not valid TOML"),
        (recording(experiment='duration = "1 N"'), "experiment: "),
        (recording(experiment="sweeep = 1"), 'unknown key "sweeep"; did you mean "sweep"'),
        (recording(without=["current", "position"]), "has none of the channels current, position"),
        (
            recording(experiment=experiment_text("floating-cylinder")),
            "its object moves, and the hand has not: base = a hand.toml with effects",
        ),
    ],
)
def test_a_recording_that_cannot_be_simulated_is_named_before_any_work(tmp_path, spoilt, said):
    file = campaign(tmp_path, '[[recording]]\nfile = "*.h5"\n', spoilt=spoilt)
    with pytest.raises(BadInput, match=said) as caught:
        read_campaign(file)
    assert str(caught.value).startswith(f"{tmp_path / 'spoilt.h5'}: ")
    assert "\n" not in str(caught.value)


def test_short_records_of_an_axis_are_named_before_any_work(tmp_path):
    channels = {"time": [0.0, 0.001], "reference": [0.0, 0.0], "position": [0.0, 0.0]}
    units = {"time": "s", "reference": "m", "position": "m", "drive": "V"}
    Recording({**channels, "drive": [0.0, 0.0]}, units).write(tmp_path / "short.h5")
    text = "plant = 'axis'\n[[recording]]\nfile = 'short.h5'"
    with pytest.raises(BadInput, match=r"short\.h5: an axis recording of 2 samples"):
        read_campaign(campaign(tmp_path, text))
