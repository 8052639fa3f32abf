"""A plant outside the package: the worked example, and the errors of wrong ones."""

import json
import math
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.check import check
from hannes.commands.cli import main
from hannes.core.effect import Term
from hannes.core.errors import BadInput
from hannes.core.kernels.jit import kernel
from hannes.core.recording.recording import Recording
from hannes.plants.plain import PlainPlant
from hannes.plants.protocol import Plant, find_plant, run_to_run_spread
from hannes.simulation.catalogue import effect

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "own_plant"


def copied(folder, *arguments):
    """The example in a folder of its own, with recordings made there; returns its campaign."""
    for file in EXAMPLE.glob("*.*"):
        shutil.copy(file, folder)
    command = [sys.executable, "record.py", *arguments]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder / "campaign.toml"


@pytest.fixture(scope="module")
def rubbing(tmp_path_factory):
    return copied(tmp_path_factory.mktemp("cart"), "--runs", "4")


def test_the_example_is_a_plant_and_its_recordings_are_clean(rubbing):
    campaign = read_campaign(rubbing, trust=True)
    assert isinstance(campaign.plant, Plant) and campaign.plant.name == "cart"
    for entry in campaign.entries:
        assert {each.level for each in check(entry.recording, campaign.plant)} == {"note"}
    spoilt = campaign.entries[0].recording
    spoilt = spoilt.with_channels({"position": 1e3 * spoilt["position"]}, {})
    faults = [each for each in check(spoilt, campaign.plant) if each.level == "fault"]
    assert faults and all("mm taken for m" in each.text for each in faults)


def test_without_friction_the_example_moves_as_a_damped_oscillator_does(rubbing):
    """Against the closed form of a step on m x'' + c x' + k x = F (any textbook)."""
    cart = find_plant("cart:Cart", rubbing.parent)
    time = np.arange(0.0, 3.0, 2e-3)
    units = {"time": "s", "push": "N", "position": "m"}
    push = np.full(time.size, 6.0)
    recording = Recording({"time": time, "push": push, "position": 0 * time}, units)
    k, c, m = cart.parameters["spring.stiffness"], cart.parameters["damper.damping"], 1.2
    decay = c / (2.0 * m)
    swing = np.sqrt(k / m - decay**2)
    wave = np.cos(swing * time) + decay / swing * np.sin(swing * time)
    exact = 6.0 / k * (1.0 - np.exp(-decay * time) * wave)
    assert np.abs(cart.simulate({}, recording)["position"] - exact).max() < 1e-7


def test_an_effect_at_off_changes_nothing_and_adds_its_force_otherwise(rubbing):
    campaign = read_campaign(rubbing, trust=True)
    place = "rail_friction"  # by its own name, wherever its file lies
    recording = campaign.entries[0].recording
    grown = campaign.plant.with_effects(campaign.effects[place])
    alone, off = (each.simulate({}, recording)["position"] for each in (campaign.plant, grown))
    assert np.array_equal(alone, off)
    rubbed = grown.simulate({"rail_friction.size": 0.6}, recording)["position"]
    assert np.abs(rubbed - alone).max() > 1e-3
    assert grown.with_effects(campaign.effects[place]).effects == grown.effects
    assert "gear_friction" in campaign.plant.accepts(campaign.effects["gear_load"])


@pytest.mark.slow
def test_the_rail_is_named_with_its_friction(rubbing, capsys):
    out = rubbing.parent / "out"
    assert main(["diagnose", str(rubbing), "--trust", "--out", str(out), "--json"]) == 0
    verdict = json.loads(capsys.readouterr().out)
    assert verdict["verdict"] in ("named", "named_with_remainder")
    assert verdict["effects"] == ["rail_friction"]
    size = verdict["parameters"]["rail_friction.size"]
    assert size["value"] == pytest.approx(0.6, rel=0.05) and size["low"] < 0.6 < size["high"]
    assert "cart" in (out / "hand.toml").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_smooth_rail_is_not_called_rubbing(tmp_path):
    from hannes.commands.diagnose import diagnose

    verdict = diagnose(copied(tmp_path, "--runs", "4", "--friction", "0"), trust=True).verdict
    assert verdict.effects == [] and verdict.verdict in ("no_gap", "recalibrated")


def test_two_folders_may_name_their_modules_alike(tmp_path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        text = (EXAMPLE / "cart.py").read_text(encoding="utf-8")
        changed = text.replace('name = "cart"', f'name = "{name}"')
        (tmp_path / name / "cart.py").write_text(changed, encoding="utf-8")
    assert [find_plant("cart:Cart", tmp_path / name).name for name in ("one", "two", "one")] == [
        "one",
        "two",
        "one",
    ]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('judged = ("position",)', 'judged = ("positon",)', 'did you mean "position"'),
        ('judged = ("position",)', "judged = ()", "nothing would be compared"),
        ('"time": "s", ', "", 'channels lacks "time": "s"'),
        ('free = {"spring.stiffness"', 'free = {"spring.stifness"', 'mean "spring.stiffness"'),
        ("block = 0.5", "block = 0.0", "block = 0.0"),
        ("class Cart(PlainPlant)", "class Cart", "it lacks parameters"),
        ('name = "cart"', 'name = ""', "name = '': expected a text"),
        ("channels = {", "channels = 3, {", "expected units by name"),
        ("class Cart(PlainPlant)", "class Cort(PlainPlant)", "cannot be loaded"),
        ("import numpy as np", "import nompy as np", "cannot be loaded"),
    ],
)
def test_a_plant_that_is_none_is_refused_in_one_line(tmp_path, old, new, said):
    text = (EXAMPLE / "cart.py").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "cart.py").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(BadInput, match=re.escape(said)) as caught:
        find_plant("cart:Cart", tmp_path)
    assert "\n" not in str(caught.value) and "cart:Cart" in str(caught.value)


def test_a_plant_without_equations_says_so():
    with pytest.raises(BadInput, match="does not say how it moves"):
        PlainPlant().simulate({}, None)


def test_an_effect_that_runs_away_gives_no_number_as_compiled_code_does():
    @kernel
    def cubic(position, size):
        """Of a spring [N]."""
        return size + position**3

    rail = effect("rail.py:RAIL_FRICTION", EXAMPLE)
    away = replace(rail, terms=(Term(cubic, writes=("friction",)),))
    cart = find_plant("cart:Cart", EXAMPLE).with_effects(away)
    assert math.isnan(cart.added("friction", {})(0.0, 1e200))


def test_effects_are_given_all_that_may_be_read_and_no_more():
    cart = find_plant("cart:Cart", EXAMPLE)
    cart = cart.with_effects(effect("rail.py:RAIL_FRICTION", EXAMPLE))
    reads = cart.open["friction"]
    assert cart.added("friction", {})(*(0.0 for _ in reads)) == 0.0
    for count in (len(reads) - 1, len(reads) + 1):
        with pytest.raises(BadInput, match=f"given {count} values: expected {', '.join(reads)}"):
            cart.added("friction", {})(*(0.0 for _ in range(count)))


def test_the_former_name_of_run_to_run_is_read_with_a_warning():
    class Former(PlainPlant):
        name = "former"
        restless: ClassVar = {"spring.stiffness": 0.5}

    class Present(PlainPlant):
        run_to_run: ClassVar = {"spring.stiffness": 0.5}

    with pytest.warns(DeprecationWarning, match="restless is now called run_to_run"):
        assert run_to_run_spread(Former()) == Former.restless
    assert run_to_run_spread(Present()) == Present.run_to_run
    assert run_to_run_spread(PlainPlant()) == {}
