"""Data never chooses Python; what a TOML names runs by consent alone, and only as it was read."""

import shutil
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

import hannes
from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.foreign.mapping_file import read_mapping
from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.core.trust import consent
from hannes.dataset.spec import load_spec
from hannes.plants.protocol import find_plant
from hannes.simulation.catalogue import effect
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.hand_file import load_hand

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_plant"
MARK = "from pathlib import Path\nPath(__file__).with_name('executed').write_text('yes')\n"
EFFECT = (
    MARK
    + "from dataclasses import replace\nfrom hannes.dynamics.capstan import EFFECT as SHIPPED\n"
    + "MINE = replace(SHIPPED, name='mine', meaning='another')\n"
)
RAMP = '[reference]\nkind = "ramp"\npoints = [["0 s", "0 rad"], ["1 s", "15 rad"]]\n'
OWN = 'effects = ["own.py:MINE"]\n'
TOMLS = {
    "campaign.toml": OWN + '[[recording]]\nfile = "r.h5"\n',
    "experiment.toml": OWN + 'duration = "20 ms"\n' + RAMP,
    "hand.toml": OWN,
    "mapping.toml": 'plant = "own.py:MINE"\n',
    "set.toml": OWN + 'duration = "20 ms"\n' + RAMP + '[[grasps]]\nshape = "none"\n',
}
READERS = {
    "campaign.toml": read_campaign,
    "experiment.toml": load_experiment,
    "hand.toml": load_hand,
    "mapping.toml": read_mapping,
    "set.toml": load_spec,
}


@pytest.fixture(autouse=True)
def afresh(tmp_path, monkeypatch):
    """Nothing remembered, nothing granted, a current folder of one's own."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setattr(consent, "_GRANTED", set())
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(EFFECT)
    time = np.arange(0.0, 0.1, 1e-3)
    channels = {"time": time, "current": 0.0 * time, "reference": 0.0 * time}
    units = {"time": "s", "current": "A", "reference": "rad"}
    Recording(channels, units).write(tmp_path / "r.h5")
    for name, text in TOMLS.items():
        (tmp_path / name).write_text(text)
    path = list(sys.path)
    yield
    assert sys.path == path


def ran(folder=Path()):
    """Whether own.py ran; forgets it."""
    mark = folder / "executed"
    found = mark.exists()
    mark.unlink(missing_ok=True)
    for name in [each for each in sys.modules if each.startswith("hannes_own_")]:
        del sys.modules[name]
    return found


@pytest.mark.parametrize("name", TOMLS)
def test_python_that_a_toml_names_needs_consent(name):
    with pytest.raises(BadInput, match="--trust") as caught:
        READERS[name](name)
    assert "\n" not in str(caught.value) and f"hannes trust {name}" in str(caught.value)
    assert not ran()
    try:
        READERS[name](name, trust=True)
    except BadInput as error:  # an effect is no plant
        assert name == "mapping.toml" and "is no plant" in str(error)
    assert ran()


@pytest.mark.parametrize("name", TOMLS)
def test_consent_is_remembered_until_a_byte_changes(name, capsys):
    assert main(["trust", name]) == 0 and "own.py" in capsys.readouterr().out
    assert not ran()  # remembering runs nothing
    with pytest.raises(BadInput) if name == "mapping.toml" else nullcontext():
        READERS[name](name)
    assert ran()
    for changed in ("own.py", name):
        before = Path(changed).read_text()
        Path(changed).write_text(before + "# changed\n")
        consent._GRANTED.clear()
        with pytest.raises(BadInput, match="--trust"):
            READERS[name](name)
        assert not ran()
        Path(changed).write_text(before)
    assert main(["trust", name, "--forget"]) == 0
    consent._GRANTED.clear()
    with pytest.raises(BadInput, match="--trust"):
        READERS[name](name)
    assert not ran()


def test_what_a_file_leads_to_is_forgotten_with_it():
    Path("leads.toml").write_text('hand = "hand.toml"\n')
    assert main(["trust", "leads.toml"]) == 0 and main(["trust", "leads.toml", "--forget"]) == 0
    consent._GRANTED.clear()
    with pytest.raises(BadInput, match="--trust"):
        load_hand("hand.toml")


def test_a_mapping_that_a_campaign_names_needs_consent_too():
    Path("mapped.toml").write_text('[[recording]]\nfile = "r.h5"\nmapping = "mapping.toml"\n')
    with pytest.raises(BadInput, match="--trust"):
        read_campaign("mapped.toml")
    assert not ran()
    assert main(["trust", "mapped.toml"]) == 0
    with pytest.raises(BadInput, match="is no plant"):
        read_campaign("mapped.toml")
    assert ran()


def test_what_is_no_toml_is_refused(capsys):
    assert main(["trust", "own.py"]) == 2
    assert "expected a TOML file" in capsys.readouterr().err


def test_another_folder_has_no_consent():
    assert main(["trust", "hand.toml"]) == 0
    shutil.copytree(".", "../moved", ignore=shutil.ignore_patterns("config"))
    with pytest.raises(BadInput, match="--trust"):
        load_hand("../moved/hand.toml")
    assert not ran(Path("../moved"))


@pytest.mark.parametrize(("answer", "runs"), [("y\n", True), ("n\n", False), ("", False)])
def test_a_terminal_is_asked(monkeypatch, capsys, answer, runs):
    import io

    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stdin", Terminal(answer))
    printed = Terminal()
    monkeypatch.setattr(sys, "stderr", printed)
    assert main(["run", "experiment.toml", "--out", "out"]) == (0 if runs else 2)
    assert "own.py:MINE" in printed.getvalue() and "[y/N]" in printed.getvalue()
    assert ran() == runs


def test_who_names_python_by_hand_has_consent(capsys):
    assert main(["effects", "own.py:MINE"]) in (0, 2)  # refused for what it adds to, once loaded
    assert ran()
    assert effect("own.py:MINE").name == "mine" and ran()
    assert effect("own:MINE").name == "mine" and ran()


def test_a_mere_look_runs_nothing(capsys):
    assert main(["trust", "hand.toml"]) == 0
    assert main(["hand", "hand.toml"]) == 0
    assert "own.py:MINE" in capsys.readouterr().out and not ran()
    assert main(["hand", "hand.toml", "--values"]) == 2 and not ran()
    Recording.read("r.h5")
    assert not ran()


@pytest.mark.parametrize("plant", ["own:MINE", "own.py:MINE", "os:system", "./own.py:MINE"])
def test_a_recording_chooses_only_among_plants_that_ship(plant, capsys):
    recording = Recording.read("r.h5")
    Recording(recording.channels, recording.units, plant=plant).write("stranger.h5")
    assert main(["check", "stranger.h5"]) == 2
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1 and "does not ship" in printed and "--plant" in printed
    assert not ran()


def test_names_of_pythons_own_beside_data_are_not_run():
    """`python -m hannes` in the folder of a harmless-looking queue.py."""
    Path("data").mkdir()
    Path("data/queue.py").write_text(MARK)
    shutil.copy("r.h5", "data/run.h5")
    command = [sys.executable, "-m", "hannes", "check", "run.h5"]
    done = subprocess.run(command, cwd="data", capture_output=True, text=True, check=False)
    assert "run.h5: " in done.stdout and not Path("data/executed").exists()


def test_an_installed_module_needs_consent_too():
    Path("named.toml").write_text('effects = ["hannes.dynamics.capstan:EFFECT"]\n')
    with pytest.raises(BadInput, match="installed module hannes"):
        load_hand("named.toml")
    assert load_hand("named.toml", trust=True).effects[0].name == "capstan"


def test_files_beside_are_loaded_from_what_was_read_and_nothing_else():
    helper = "NUMBER = 1\n"
    Path("helper.py").write_text(helper)
    Path("queue.py").write_text(MARK)
    Path("package").mkdir()
    Path("package/__init__.py").write_text("from .inner import LETTER\n")
    Path("package/inner.py").write_text("LETTER = 'b'\n")
    text = "import helper\nimport queue\nfrom package import LETTER\nimport package.inner\n"
    late = "import importlib\ndef late():\n    return importlib.import_module('helper')\n"
    Path("own.py").write_text(EFFECT + text + late + "QUEUE = queue\nHELPER = helper\n")
    assert main(["trust", "hand.toml"]) == 0
    (mine,) = load_hand("hand.toml").effects
    assert mine.name == "mine" and "helper" not in sys.modules
    module = next(
        each
        for n, each in sys.modules.items()
        if n.startswith("hannes_own_") and n.endswith(".own")
    )
    assert module.QUEUE is sys.modules["queue"] and module.HELPER.NUMBER == 1
    assert module.LETTER == "b" and not Path("__pycache__").exists()
    with pytest.raises(ModuleNotFoundError):
        module.late()
    ran()
    Path("helper.py").write_text("NUMBER = 2\n")
    consent._GRANTED.clear()
    with pytest.raises(BadInput, match="--trust"):
        load_hand("hand.toml")


def test_plants_and_effects_are_taken_as_objects():
    plant = find_plant("cart:Cart", EXAMPLE)
    rail = effect("rail.py:RAIL_FRICTION", EXAMPLE)
    consent._GRANTED.clear()
    time = np.arange(0.0, 0.1, 1e-3)
    units = {"time": "s", "push": "N", "position": "m"}
    Recording({"time": time, "push": 0.0 * time, "position": 0.0 * time}, units).write("c.csv")
    Path("cart.toml").write_text('plant = "cart:Cart"\n[[recording]]\nfile = "c.csv"\n')
    found = read_campaign("cart.toml", plant=plant, effects=[rail])
    assert found.plant is plant and found.effects["rail_friction"] is rail
    assert hannes.Hand([effect("own.py:MINE")]).effects[0].name == "mine"


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("own.py:", "names no Python"),
        ("own.py:a.b", "names no Python"),
        ("..own:X", "names no Python"),
        ("nowhere.py:X", "cannot read"),
        (".:X", "names no Python"),
        ("x" * 300 + ".py:X", "cannot read"),
        ("config.py:X", "cannot read"),
    ],
)
def test_what_means_no_python_is_one_line(name, said):
    with pytest.raises(BadInput, match=said) as caught:
        effect(name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "body",
    [
        "    def __init__(self, effects=()): 1 / 0",
        "    @property\n    def judged(self): raise KeyError('x')",
        "    free = property(lambda self: 1 / 0)",
    ],
)
def test_a_plant_that_raises_when_made_or_looked_at_is_one_line(body, capsys):
    head = "from hannes.plants.plain import PlainPlant\nclass Mine(PlainPlant):\n"
    Path("mine.py").write_text(head + body + "\n")
    assert main(["check", "r.h5", "--plant", "mine.py:Mine"]) == 2
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1 and "plant mine.py:Mine raises" in printed


def test_a_name_that_no_file_can_have_leads_nowhere(tmp_path):
    toml = tmp_path / "campaign.toml"
    toml.write_text(f'base = "{300 * "h"}.toml"\n')
    assert consent.reached(toml) == [toml]
