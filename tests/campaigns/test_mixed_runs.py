"""Two machines under one command: named where runs form two groups, not where they scatter."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.mixed_runs import mixed_runs, several_units
from hannes.campaigns.warnings import campaign_warnings
from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.identification.calibration.data_check import data_issues
from hannes.plants.hand.plant import HandPlant

TIME = np.arange(900) / 500.0
ASKED = np.interp(TIME, (0.0, 0.7, 0.9, 1.6), (0.0, 8.0, 8.0, 0.0))
UNITS = {"time": "s", "reference": "rad", "position": "rad", "current": "A", "duty": "1"}


def run(rng, scatter=0.01, slack=0.0, resistance=3.0, start=0.005, channels=tuple(UNITS)):
    """A closing and an opening: friction, spring and winding of this run scatter."""
    friction, spring, winding = 1.0 + scatter * rng.standard_normal(3)
    asked = np.interp(TIME - 0.04 - start * rng.standard_normal(), TIME, ASKED)
    speed = np.gradient(asked, TIME)
    load = 0.03 * spring * np.maximum(asked - slack, 0.0) + 0.15 * friction * np.tanh(speed)
    current = load + 0.01 * rng.standard_normal(TIME.size)
    duty = (winding * resistance * load + 0.25 * speed) / 12.0
    found = dict(zip(UNITS, (TIME, ASKED, asked, current, duty), strict=True))
    found = {name: found[name] for name in channels}
    return Recording(found, {name: UNITS[name] for name in found}, "hand")


def campaign(runs, units=()):
    units = units or [""] * len(runs)
    entries = [Entry(f"{k}.csv", r, "closing", "fit", unit=u)
               for k, (r, u) in enumerate(zip(runs, units, strict=True))]  # fmt: skip
    plant = HandPlant()
    return Campaign(plant, plant, tuple(entries), Path("."), {})


OTHER = {"slack": 1.0, "resistance": 5.0}


@pytest.mark.parametrize("channels", [tuple(UNITS), ("time", "reference", "position", "current")])
def test_two_hands_under_one_command_are_named(channels):
    rng = np.random.default_rng(0)
    hands = ({}, OTHER, {}, OTHER)
    runs = [run(rng, 0.003, channels=channels, **hand) for hand in hands]
    (found,) = mixed_runs(campaign(runs))
    assert (found.level, found.kind) == ("fault", "mixed")
    assert "1.csv, 3.csv are of another machine" in found.text
    assert "a campaign of their own" in found.text
    apart = campaign(runs, ["", "other", "", "other"])
    assert not list(mixed_runs(apart)) and not list(several_units(campaign(runs)))
    with pytest.raises(BadInput, match="are fitted as one machine"):
        data_issues(apart, ("saturated",))
    assert not list(mixed_runs(campaign(runs[:3])))


def test_the_smaller_group_is_the_odd_one():
    rng = np.random.default_rng(1)
    runs = [run(rng, **hand) for hand in (OTHER, OTHER, {}, {}, {})]
    (found,) = mixed_runs(campaign(runs))
    assert "most: 0.csv, 1.csv are of another" in found.text


@pytest.mark.parametrize("scatter", [0.005, 0.01, 0.02])
def test_one_hand_that_scatters_is_one(scatter):
    rng = np.random.default_rng(2)
    sets = [[run(rng, scatter, start=0.01) for _ in range(rng.integers(4, 9))] for _ in range(120)]
    assert not [each for each in sets if list(mixed_runs(campaign(each)))]


def test_runs_that_drift_and_runs_of_another_command_are_not_two_hands():
    rng = np.random.default_rng(3)
    drift = [run(rng, 0.003, resistance=3.0 + 0.4 * k) for k in range(6)]
    assert not list(mixed_runs(campaign(drift)))
    runs = [run(rng, 0.003, **hand) for hand in ({}, {}, OTHER, OTHER)]
    slow = [each.with_channels({"reference": 0.5 * ASKED}, {}) for each in runs[2:]]
    assert not list(mixed_runs(campaign([*runs[:2], *slow])))


def test_the_check_and_every_fit_refuse_them(tmp_path, capsys):
    rng = np.random.default_rng(4)
    runs = [run(rng, 0.003, **hand) for hand in ({}, {}, OTHER, OTHER)]
    with pytest.raises(BadInput, match="two groups"):
        campaign_warnings(campaign(runs))
    for k, each in enumerate(runs):
        replace(each, plant="hand").write(tmp_path / f"{k}.csv")
    text = '[[recording]]\nfile = "*.csv"\nexperiment = "void-closure"\ncondition = "closing"\n'
    (tmp_path / "campaign.toml").write_text(text)
    assert main(["check", str(tmp_path / "campaign.toml")]) == 2
    shown = capsys.readouterr()
    assert "2.csv, 3.csv are of another machine" in shown.out
