"""The benchmark `guards`: what it hides, what it counts, and one case whole."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.guarding.plan import KINDS, NAMED, SHIPPED, SPREAD, cases, hidden, plan
from benchmarks.guarding.work import measured
from benchmarks.guards import figures
from benchmarks.truth.campaign import Spread, make
from benchmarks.truth.effects import SIZES
from benchmarks.truth.protocol import PROTOCOLS
from hannes.campaigns.campaign_file import read_campaign


def test_thirty_campaigns_ten_of_them_by_users_who_state_nothing():
    names = [name for name, _ in cases("quoted", False)]
    assert len(names) == len(set(cases("quoted", False))) == 30
    assert sum(not NAMED[name].stated for name in names) == 10
    assert not set(cases("quoted", False)) & set(cases("development", False))


def test_large_effects_lie_between_a_tenth_and_the_end_of_their_range():
    large = next(kind for kind in KINDS if kind.large)
    sizes = [hidden(large, seed) for seed in range(200)]
    shares = [abs(size) / SIZES[name].high for each in sizes for name, size in each.items()]
    assert min(shares) >= 0.1 and max(shares) <= 1.0 and np.mean(np.array(shares) > 0.5) > 0.2
    assert hidden(NAMED["sound, stated"], 1) == {}


@pytest.fixture(scope="module")
def short():
    """One closure of the poor protocol, by a hand whose joints differ, and by one where not."""
    poor = PROTOCOLS["poor"]
    one = replace(poor, conditions=(replace(poor.conditions[0], repeats=1),))
    return [make(one, 5, {}, Spread(finger=share)) for share in (0.0, 0.01)]


def test_joints_differ_for_themselves_without_moving_what_is_shared(short):
    alike, apart = short
    shared = [name for name in alike.answer["hand"] if not name.startswith("finger_share")]
    assert [alike.answer["hand"][n] for n in shared] == [apart.answer["hand"][n] for n in shared]
    own = [x for n, x in apart.answer["hand"].items() if n.startswith("finger_share.mcp_moment")]
    assert len(set(own)) == 5 and 0.002 < np.std(own) < 0.025
    one, other = (each.recordings["01_void"]["current"] for each in short)
    assert 1e-3 < np.sqrt(np.mean((one - other) ** 2)) < 0.1


def test_who_states_nothing_names_shipped_experiments_alone(short, tmp_path):
    short[1].write_unstated(tmp_path, SHIPPED)
    campaign = read_campaign(tmp_path / "campaign.toml")
    assert campaign.diagnose.content == {}
    assert 'controller = "continuous"' in campaign.entries[0].recording.experiment
    assert not (tmp_path / "sealed").exists() and not (tmp_path / "hand.toml").exists()


def test_the_campaign_is_the_poor_one_with_further_runs_after_it():
    assert plan().runs[:12] == PROTOCOLS["poor"].runs and len(plan().runs) == 20
    assert SPREAD.finger == 0.01


def test_a_raised_gap_and_a_missing_answer_are_counted():
    base = {"kind": KINDS[0].name, "hidden": {"leader_slack.length": 2e-3}, "named": []}
    done = [
        {**base, "verdict": "named", "named": ["leader_slack"], "processor_seconds": 9.0},
        {**base, "verdict": "unknown", "worse": ["named: ..."], "processor_seconds": 9.0},
        {**base, "verdict": "none"},
        {**base, "verdict": "unknown", "processor_seconds": 130.0},
        {"kind": KINDS[0].name, "hidden": {}, "not_made": "no hand"},
    ]
    rows, bounds = figures(done)
    assert (rows[0]["cases"], rows[0]["right_name"], rows[0]["wrong_name"]) == (4, 1, 0)
    assert [(each["value"], each["holds"]) for each in bounds] == [(1, False), (2, False)]


@pytest.mark.slow
def test_a_case_ends_with_a_verdict_that_raises_no_gap():
    ((name, seed),) = cases("development", True)
    found = measured(name, seed)
    assert found["verdict"] in ("no_gap", "recalibrated", "unknown") and found["worse"] == []
    assert found["changes"] and found["processor_seconds"] > 0.0
