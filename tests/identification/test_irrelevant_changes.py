"""A verdict depends on what was recorded: not on names, places, order of keys, or processors."""

import json
import os
from typing import ClassVar

import numpy as np
import oven
import pytest

from hannes.commands.calibrate import calibrate
from hannes.commands.diagnose import diagnose

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
