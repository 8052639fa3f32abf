"""What a verdict says of the machine itself: refitted values, their intervals, in which order."""

import json

import numpy as np
import pytest
from sled import Sled, campaign, found

from hannes.commands.diagnose import diagnose
from hannes.identification.baseline_table import Refitted, baseline_table


def truth(seed):
    """The sled's own values, as `sled.recordings` draws them."""
    rng = np.random.default_rng(seed)
    return {
        name: Sled().parameters[name] * (1.0 + 0.02 * rng.standard_normal())
        for name in Sled.uncertain
    }


def test_intervals_of_the_baseline_hold_the_truth():
    """Of 18 intervals of 95 %, at least 15: fewer by chance once in a thousand times."""
    held = 0
    for seed in range(2, 8):
        rows, true = found(seed).baseline["parameters"], truth(seed)
        assert sorted(row["name"] for row in rows) == sorted(true)
        held += sum(row["low"] < true[row["name"]] < row["high"] for row in rows)
        for row in rows:  # 2 % is what the bench says of its scatter
            prior = 0.02 * row["nominal"]
            assert row["moved"] == pytest.approx((row["value"] - row["nominal"]) / prior)
            assert row["high"] - row["low"] < 2 * 1.96 * prior
    assert held >= 15


def test_recalibrated_says_what_was_off_in_file_page_and_terminal(tmp_path):
    out = tmp_path / "out"
    verdict = diagnose(campaign(4), out=out, progress=False).verdict
    assert verdict.verdict == "recalibrated"
    written = json.loads((out / "verdict.json").read_text(encoding="utf-8"))["baseline"]
    assert written == verdict.baseline and "Hessian with priors" in written["intervals_from"]
    rows = written["parameters"]
    assert [abs(row["moved"]) for row in rows] == sorted(
        (abs(row["moved"]) for row in rows), reverse=True
    )
    text = (out / "report.html").read_text(encoding="utf-8")
    assert text.index("What was off") < text.index("Before and after")
    first = rows[0]
    (line,) = [each for each in verdict.summary().splitlines() if each.startswith("moved most")]
    assert f"{first['name']} {first['nominal']:.4g} -> {first['value']:.4g}" in line
    assert f"({first['moved']:+.1f})" in line


def test_an_interval_ends_at_the_bounds_and_the_most_moved_comes_first():
    little = Refitted("a", "m", 1.0, 1.1, 0.2, 1.0, (0.0, 5.0))
    much = Refitted("b", "m", 1.0, 0.1, 0.2, 0.3, (0.0, 5.0), "cylinder")
    table = baseline_table([little, much], "a test")
    first, second = table["parameters"]
    assert (first["name"], first["of"], second["name"]) == ("b", "cylinder", "a")
    assert first["moved"] == pytest.approx(-3.0)
    assert first["low"] == 0.0 and first["high"] == pytest.approx(0.1 + 1.96 * 0.2)
