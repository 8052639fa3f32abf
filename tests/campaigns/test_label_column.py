"""The column that numbers or names runs."""

import pytest

from hannes.campaigns.begin.column_guess import label_column, maybe_label
from hannes.commands.cli import main


@pytest.mark.parametrize(
    ("name", "cells", "found"),
    [
        ("Versuch", ["V1"] * 6 + ["V2"] * 6, True),  # a word of another language
        ("Versuch", ["V1"] * 12, True),  # the beginning holds the first run alone
        ("set", ["A 1"] * 6 + ["A 2"] * 6, False),  # may be states of one run
        ("state", ["on", "off"] * 6, False),
        ("state", ["on"] * 12, False),
        ("step", ["s1", "s2"] * 6, False),  # changes all the time
        ("trial", ["1", "2", "3", "4"] * 3, False),
    ],
)
def test_a_label_has_a_known_name_and_seldom_changes(name, cells, found):
    rows = [(f"{k}", cell, "0.5") for k, cell in enumerate(cells)]
    assert label_column(("time", name, "position"), rows) == (name if found else "")


@pytest.mark.parametrize(
    ("cells", "asked"),
    [
        (["A 1"] * 6 + ["A 2"] * 6, True),
        (["A 1"] * 12, False),
        (["s1", "s2"] * 6, False),  # changes all the time
        (["on"] * 6 + ["off"] * 6, False),
    ],
)
def test_words_with_numbers_that_seldom_change_may_name_runs(cells, asked):
    rows = [(f"{k}", cell, "0.5") for k, cell in enumerate(cells)]
    assert maybe_label(("time", "set", "position"), rows) == ("set" if asked else "")


def test_whether_they_name_runs_is_asked_and_never_guessed(tmp_path, capsys):
    log = tmp_path / "log.csv"
    rows = [f"{0.01 * k:.2f},A {1 + k // 50},{0.1 * k:.1f},0.5" for k in range(100)]
    log.write_text("time [s],set,position [rad],current [A]\n" + "\n".join(rows) + "\n")
    assert main(["begin", str(log), "--plant", "axis", "--out", str(tmp_path / "bench")]) == 0
    assert 'does "set" name runs?' in capsys.readouterr().out
    assert 'split = "?"' in (tmp_path / "bench" / "mapping.toml").read_text()
