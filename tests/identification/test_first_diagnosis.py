"""Diagnosis, whole: hidden slack is named, its answer there or gone, none is not; the real axis."""

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest

from hannes.campaigns import third_party
from hannes.commands.cli import main
from hannes.commands.diagnose import diagnose
from hannes.core.errors import MissingRecording
from hannes.simulation.hand.hand_file import load_hand

FIELDS = {
    *("verdict", "effects", "parameters", "gap", "where", "candidates", "next_run", "reason"),
    *("tried", "alpha", "recordings", "smallest_detectable", "seed", "versions"),
}


def closures(folder, *arguments):
    """Recordings made by the second hand, in another process; returns their campaign."""
    command = [sys.executable, "-m", "benchmarks.truth.closures", "--out", str(folder)]
    subprocess.run([*command, "--runs", "6", *arguments], check=True, capture_output=True)
    return folder / "campaign.toml"


@pytest.mark.slow
def test_lengths_of_hidden_slack_are_right_over_several_draws(tmp_path):
    """One draw says little: its interval may miss, and rounding alone moves its size."""
    found = []
    for seed in range(1, 6):
        campaign = closures(tmp_path / str(seed), "--slack", "3 mm", "--seed", str(seed))
        verdict = diagnose(campaign, progress=False).verdict
        assert verdict.effects == ["leader_slack"]
        length = verdict.parameters["leader_slack.length"]
        found.append([length["value"], length["low"], length["high"]])
    value, low, high = np.array(found).T
    assert np.median(value) == pytest.approx(3e-3, rel=0.03)
    assert np.sum((low < 3e-3) & (high > 3e-3)) >= 4
    assert np.median(high - low) < 0.12 * 3e-3


@pytest.mark.slow
def test_hidden_slack_is_named_with_its_length(tmp_path, capsys):
    campaign = closures(tmp_path / "loose", "--slack", "3 mm", "--seed", "1")
    assert main(["diagnose", str(campaign), "--out", str(tmp_path / "out"), "--json"]) == 0
    written = json.loads(capsys.readouterr().out)
    assert written == json.loads((tmp_path / "out" / "verdict.json").read_text(encoding="utf-8"))
    assert set(written) >= FIELDS
    assert written["effects"] == ["leader_slack"]
    assert written["verdict"] in ("named", "named_with_remainder")  # rounding decides, of one draw
    assert min(row["gain_select"] for row in written["candidates"]) >= 0.0
    assert written["parameters"]["leader_slack.length"]["unit"] == "m"
    for name in ("current", "duty"):
        assert (
            written["gap"][name]["after"]
            < written["gap"][name]["before"]
            < written["gap"][name]["as_given"]
        )
    hand = load_hand(tmp_path / "out" / "hand.toml")
    assert [each.name for each in hand.present_effects()] == ["leader_slack"]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<script" not in page and 'src="http' not in page
    shutil.rmtree(campaign.parent / "sealed")  # where the answer lay
    diagnose(campaign, out=tmp_path / "again", progress=False)
    verdicts = [(tmp_path / name / "verdict.json").read_bytes() for name in ("out", "again")]
    assert verdicts[0] == verdicts[1]


@pytest.mark.slow
@pytest.mark.parametrize("seed", ["1", "11"])
def test_the_same_closures_without_slack_are_not_called_slack(tmp_path, seed):
    campaign = closures(tmp_path / "taut", "--slack", "none", "--seed", seed)
    verdict = diagnose(campaign).verdict
    assert verdict.effects == []
    assert verdict.verdict in ("no_gap", "recalibrated")


@pytest.mark.slow
def test_the_real_axis_rubs_harder_one_way():
    try:
        third_party.folder("emps")
    except MissingRecording as missing:
        pytest.skip(f"needs the EMPS recordings: {missing}")
    verdict = diagnose("emps").verdict
    assert verdict.effects == ["direction_friction"]
    gap = verdict.gap["drive"]
    assert gap["before_percent"] - gap["after_percent"] >= 0.5
    assert verdict.verdict == "named_with_remainder"
