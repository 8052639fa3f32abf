"""The naming study of the servo: what it draws, how it scores, and one case of each quick kind."""

import json
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest

from benchmarks.naming_study import servo_bench, servo_draw, servo_study
from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.check import check


def test_the_study_has_sixty_cases_with_an_effect_and_twenty_sound():
    kinds = Counter(kind for kind, _ in servo_study.cases("development", False))
    assert kinds.pop("sound") == 20 and sum(kinds.values()) == 60
    assert set(kinds) == {*servo_draw.RANGES, "pair"}
    seeds = {name: {s for _, s in servo_study.cases(name, False)} for name in servo_study.SETS}
    assert max(seeds["development"]) < 1000 and not seeds["development"] & seeds["quoted"]


@pytest.mark.parametrize("kind", [*servo_draw.RANGES, "pair"])
def test_what_is_hidden_is_at_least_twice_what_can_be_seen_and_in_its_range(kind):
    for seed in range(20):
        case = servo_draw.drawn(kind, seed)
        assert case == servo_draw.drawn(kind, seed) and len(case.effects) == 1 + (kind == "pair")
        for effect in case.effects:
            name, most = servo_draw.RANGES[effect]
            size = case.values.get(name, case.values.get("tilted", 0.0) * 0.4)
            assert 2.0 * servo_draw.smallest(effect) * 0.99 <= size <= most * 1.001


def test_sizes_are_far_below_the_ends_of_their_ranges():
    for effect, (_, most) in servo_draw.RANGES.items():
        assert 0.0 < servo_draw.smallest(effect) < 0.1 * most


def test_a_campaign_is_clean_and_the_same_for_one_seed(tmp_path):
    made = [servo_bench.make(tmp_path / name, 3, {}) for name in ("one", "two")]
    assert len({(each.parent / "swing_2.csv").read_bytes() for each in made}) == 1
    campaign = read_campaign(made[0], trust=True)
    assert len(campaign.entries) == 12
    for entry in campaign.entries:
        assert "fault" not in {each.level for each in check(entry.recording, campaign.plant)}
        assert np.ptp(entry.recording["position"]) > 0.6


@pytest.mark.parametrize(
    ("hidden", "said", "named", "counts"),
    [
        ((), "no_gap", [], "sound"),
        ((), "recalibrated", [], "sound"),
        ((), "unknown", [], "called"),
        (("a",), "named_with_remainder", ["a"], "right"),
        (("a",), "one_of", ["b", "a"], "class"),
        (("a",), "one_of", ["b", "c"], "wrong"),
        (("a",), "named", ["a", "b"], "wrong"),
        (("a",), "recalibrated", [], "silent"),
        (("a", "b"), "named", ["a"], "part"),
        (("a", "b"), "named", ["b", "a"], "right"),
        (("a", "b"), "unknown", [], "unknown"),
    ],
)
def test_outcomes(hidden, said, named, counts):
    assert servo_study.outcome(hidden, said, named) == counts


def test_bounds_scale_with_what_was_measured():
    done = [{"kind": "gear_load", "outcome": "right"}, {"kind": "sound", "outcome": "sound"}]
    rows, bounds = servo_study.figures(done)
    assert [row["cases"] for row in rows] == [1, 1] and all(each["holds"] for each in bounds)
    bad = [*done, *({"kind": "sound", "outcome": "called"},) * 2]
    assert [each["holds"] for each in servo_study.figures(bad)[1]] == [True, True, False]


@pytest.mark.slow
def test_the_quick_form_runs_and_resumes(tmp_path):
    command = [sys.executable, "-m", "benchmarks.naming", "--machine", "servo", "--quick"]
    command += ["--resume", "--cases", str(tmp_path / "cases.jsonl"), "--json", "-"]
    for _ in range(2):
        run = subprocess.run(command, check=True, capture_output=True, text=True)
    found = json.loads(run.stdout)
    assert [row["cases"] for row in found["rows"]] == [1, 1]
    assert all(each["holds"] for each in found["must_show"])
