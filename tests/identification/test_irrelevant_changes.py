"""A verdict depends on what was recorded: not on names, places, order of keys, or processors."""

import json
import os
import subprocess
import sys
import tomllib
from typing import ClassVar

import numpy as np
import oven
import pytest
import tomli_w

from hannes.commands.calibrate import calibrate
from hannes.commands.diagnose import diagnose
from hannes.core.recording.recording import Recording

RUNS, HIDDEN = 8, {"oven.hidden": 0.2}


class LitOven(oven.Oven):
    """The oven with a channel that nobody judges and nothing is driven by."""

    channels: ClassVar = {**oven.UNITS, "lamp": "V"}


def written(folder, name="run", order=0, lamp=False):
    """A campaign in `folder`; `order` turns round tables and their keys."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(3)
    for k in range(RUNS):
        made = oven.run(rng, HIDDEN, power=1.0 + k % 2)
        if lamp:
            values = np.random.default_rng(k).standard_normal(len(made))
            made = made.with_channels({"lamp": values}, {"lamp": "V"})
        made.write(folder / f"{name}_{k % 2}_{k}.csv")
    rows = [
        [f'file = "{name}_{k}_*.csv"', f'condition = "power {k}"', 'runs = ":"'] for k in range(2)
    ]
    tables = [["[calibrate]", 'parameters = ["oven.gain", "oven.time"]', 'loss = "linear"']]
    head = ['title = "The same"', 'out = "out"']
    if order:
        rows, head = [row[::-1] for row in rows], head[::-1]
        tables = [[table[0], *table[:0:-1]] for table in tables]
    rows = [["[[recording]]", *row] for row in rows]
    blocks = [*tables, *rows] if order else [*rows, *tables]
    text = "\n".join(line for block in [head, *blocks] for line in block)
    (folder / "campaign.toml").write_text(text + "\n")
    return folder / "campaign.toml"


def read(file):
    from hannes.campaigns.campaign_file import read_campaign

    return read_campaign(file, plant=LitOven())


def verdict(file, name="run"):
    """Text of the verdict, names of files apart."""
    found = diagnose(read(file), progress=False).verdict.json()
    assert json.loads(found)["verdict"]
    return found.replace(f"{name}_", "run_")


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    return verdict(written(tmp_path_factory.mktemp("usual") / "here"))


def test_the_names_and_the_folder_of_recordings_change_nothing(usual, tmp_path):
    assert verdict(written(tmp_path / "else" / "where", "trial"), "trial") == usual


def test_the_order_of_tables_and_keys_changes_nothing(usual, tmp_path):
    assert verdict(written(tmp_path / "here", order=1)) == usual


def test_an_irrelevant_channel_changes_nothing(usual, tmp_path):
    assert verdict(written(tmp_path / "here", lamp=True)) == usual


@pytest.mark.parametrize("count", [1, 2])
def test_the_number_of_workers_changes_nothing(usual, tmp_path, monkeypatch, count):
    file = written(tmp_path / "here")
    asked = [calibrate(read(file), workers=each, progress=False).json() for each in (1, 2)]
    assert asked[0] == asked[1]
    monkeypatch.setattr(os, "cpu_count", lambda: count)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(count)), raising=False)
    assert verdict(file) == usual


def test_what_was_recorded_does_change_it(usual, tmp_path):
    file = written(tmp_path / "here")
    first = next(iter(sorted(file.parent.glob("run_0_*.csv"))))
    lines = first.read_text().splitlines()
    cells = lines[50].split(",")
    lines[50] = ",".join([*cells[:2], str(float(cells[2]) + 0.01), *cells[3:]])
    first.write_text("\n".join(lines) + "\n")
    assert verdict(file) != usual


def of_hand(file, names=()):
    """Text of the verdict on a campaign of the hand; `names`: of files, and what they were."""
    from hannes.campaigns.campaign_file import read_campaign

    found = diagnose(read_campaign(file), progress=False).verdict.json()
    assert json.loads(found)["verdict"]
    for new, old in dict(names).items():
        found = found.replace(new, old)
    return found


@pytest.fixture(scope="module")
def closures(tmp_path_factory):
    """Three closures of a hand with a slack leader wire, made by the second formulation."""
    folder = tmp_path_factory.mktemp("closures") / "here"
    words = ["--out", str(folder), "--slack", "3 mm", "--runs", "3", "--seed", "1"]
    command = [sys.executable, "-m", "benchmarks.truth.closures", *words]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "campaign.toml"


@pytest.fixture(scope="module")
def usual_hand(closures):
    return of_hand(closures)


def copied(closures, folder, names=(), order=False, lamp=False):
    """The same campaign elsewhere: files of other names, keys turned round, a channel more."""
    folder.mkdir(parents=True)
    said = tomllib.loads(closures.read_text())
    known = {old: new for new, old in dict(names).items()}
    for row in said["recording"]:
        made = Recording.read(closures.parent / row["file"])
        if lamp:
            values = np.random.default_rng(1).standard_normal(len(made))
            made = made.with_channels({"lamp": values}, {"lamp": "V"})
        stem = row["file"].removesuffix(".csv")
        row["file"] = f"{known.get(stem, stem)}.csv"
        made.write(folder / row["file"])
    for each in ("hand.toml", "closure.toml"):
        content = tomllib.loads((closures.parent / each).read_text())
        (folder / each).write_text(tomli_w.dumps(turned(content) if order else content))
    (folder / "campaign.toml").write_text(tomli_w.dumps(turned(said) if order else said))
    return folder / "campaign.toml"


def turned(content):
    """Tables with their keys in reverse order; lists stay as they are."""
    if isinstance(content, list):
        return [turned(each) for each in content]
    if not isinstance(content, dict):
        return content
    return {key: turned(content[key]) for key in reversed(content)}


@pytest.mark.slow
def test_names_and_folder_of_a_hands_recordings_change_nothing(closures, usual_hand, tmp_path):
    rows = tomllib.loads(closures.read_text())["recording"]
    stems = [row["file"].removesuffix(".csv") for row in rows]
    names = {f"trial_{9 - k}": stem for k, stem in enumerate(stems)}  # in another order, by name
    file = copied(closures, tmp_path / "else" / "where", names)
    assert of_hand(file, names=names) == usual_hand


@pytest.mark.slow
def test_order_of_a_hands_tables_and_keys_changes_nothing(closures, usual_hand, tmp_path):
    assert of_hand(copied(closures, tmp_path / "here", order=True)) == usual_hand


@pytest.mark.slow
def test_an_irrelevant_channel_of_a_hands_recordings_changes_nothing(
    closures, usual_hand, tmp_path
):
    assert of_hand(copied(closures, tmp_path / "here", lamp=True)) == usual_hand


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 3])
def test_the_number_of_workers_changes_nothing_of_a_hand(closures, usual_hand, monkeypatch, count):
    monkeypatch.setattr(os, "cpu_count", lambda: count)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(count)), raising=False)
    assert of_hand(closures) == usual_hand
