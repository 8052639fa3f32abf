"""Sound campaigns about a linearisation: runs are sums of columns, and false alarms are counted."""

import numpy as np
import pytest

from benchmarks import false_alarms
from benchmarks.linearised import campaign, plant, tangent
from benchmarks.linearised.plant import LinearHand
from benchmarks.linearised.tangent import Shaped, Tangent, amplitudes, nominal
from benchmarks.truth.effects import SIZES
from benchmarks.truth.noise import current_noise
from hannes import effects
from hannes.campaigns.campaign_file import read_campaign
from hannes.core.recording.recording import Recording

SAMPLES = 200
SHAPED = {
    "stribeck.torque": ("stribeck.speed", False),
    "torque_ripple.amplitude": ("torque_ripple.cycles", True),
}


def made_up(name):
    """Columns of random numbers, in place of a truth that takes a minute."""
    rng = np.random.default_rng(len(name))
    channels = tangent.names_of(tangent.CONDITIONS[name])
    size = len(channels) * SAMPLES
    columns = {n: rng.standard_normal(size) for n in amplitudes() if n not in SHAPED}
    for effect, (shape, phased) in SHAPED.items():
        rows = rng.standard_normal((5, 2, size) if phased else (5, size))
        columns[effect] = Shaped(shape, np.array([1.0, 2.0, 3.0, 4.0, 5.0]), rows, phased)
    values = {n: rng.standard_normal(size) for n in nominal()}
    return Tangent(channels, rng.standard_normal(size), values, columns)


@pytest.fixture(autouse=True)
def columns(monkeypatch):
    known = {name: made_up(name) for name in tangent.CONDITIONS}
    for module in (plant, campaign):
        monkeypatch.setattr(module, "tangent", known.__getitem__)
    return known


@pytest.fixture
def void():
    time = np.arange(SAMPLES) / 1000.0
    channels = {"time": time, "reference": time, "position": time}
    text = campaign.bench.experiment_text(tangent.CONDITIONS["void"])
    return Recording(channels, {"time": "s", "reference": "rad", "position": "rad"},
                     experiment=text, hand=campaign.SHIPPED)  # fmt: skip


def test_runs_are_sums_of_columns(columns, void):
    hand = LinearHand().with_effects(
        *(effects()[n] for n in ("gear_load", "stribeck", "torque_ripple"))
    )
    one = columns["void"]
    at = {
        "motor.resistance": nominal()["motor.resistance"] + 0.1,
        "gear_load.coefficient": 0.02,
        "stribeck.torque": 1e-3,
        "stribeck.speed": 3.0,
        "torque_ripple.amplitude": 2e-3,
        "torque_ripple.cycles": 4.0,
        "torque_ripple.phase": 0.5,
    }
    wanted = one.base + 0.1 * one.values["motor.resistance"]
    wanted = wanted + 0.02 * one.effects["gear_load.coefficient"]
    wanted = wanted + 1e-3 * one.effects["stribeck.torque"].rows[2]
    both = one.effects["torque_ripple.amplitude"].rows[3]
    wanted = wanted + 2e-3 * (np.cos(0.5) * both[0] + np.sin(0.5) * both[1])
    found = hand.simulate(at, void)
    assert list(found) == ["position", "current"]
    np.testing.assert_allclose(np.concatenate(list(found.values())), wanted)
    many = hand.many({n: np.array([nominal().get(n, 0.0), x]) for n, x in at.items()}, void,
                     ("current",), True)  # fmt: skip
    np.testing.assert_allclose(many[1]["current"], found["current"])


def test_each_joint_is_off_by_its_own_column(columns, void):
    changes = LinearHand().apart({}, 0.01, void, ("position",))
    up, down = changes["ring_pip.spring_preload"]
    own = columns["void"].values["ring.pip_spring_preload"][:SAMPLES]
    np.testing.assert_allclose(up["position"], 0.01 * own)
    np.testing.assert_allclose(down["position"], -up["position"])


def test_effects_without_a_column_are_not_tried():
    hand = LinearHand()
    assert "no column" in hand.accepts(effects()["measurement_delay"])
    assert hand.accepts(effects()["gear_load"]) == ""
    assert all(hand.accepts(each) == "" for each in hand.catalogue.values())
    assert {name.partition(".")[0] for name in amplitudes()} == set(effects()) - {
        "measurement_delay"
    }


def test_a_campaign_is_what_a_seed_says_and_scatters_as_stated(tmp_path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        campaign.write(5, 100.0, tmp_path / name)
    one, two = (read_campaign(tmp_path / n / "campaign.toml", trust=True) for n in ("one", "two"))
    assert len(one.entries) == 12 and isinstance(one.plant, LinearHand)
    for mine, other in zip(one.entries, two.entries, strict=True):
        np.testing.assert_array_equal(mine.recording["current"], other.recording["current"])
    hands = [campaign.hand(seed) for seed in range(300)]
    arms = [hand["ring.mcp_moment_arm"] for hand in hands]
    assert np.std(arms) == pytest.approx(0.01, rel=0.15)
    shared = [hand["mcp.moment_arm"] / nominal()["mcp.moment_arm"] for hand in hands]
    assert np.std(shared) == pytest.approx(0.02, rel=0.15)
    assert "controller.period" not in hands[0] and "object.x" in hands[0]


def test_noise_has_the_stated_bandwidth():
    still = {"current": np.zeros(50_000), "position": np.zeros(50_000)}
    found = campaign.sensed(still, np.random.default_rng(2), 50.0)
    kept = np.corrcoef(found["current"][1:], found["current"][:-1])[0, 1]
    white = current_noise(np.random.default_rng(2), 50_000, 50.0)
    assert kept > 0.6 and np.std(found["current"] - white) < 2e-3
    assert np.std(found["position"]) == pytest.approx(2 * np.pi / 2**12 / 12**0.5, rel=0.02)


def test_a_quarter_has_coloured_noise_and_false_alarms_are_counted():
    wanted = false_alarms.cases(7, 2000)
    kinds = [kind for kind, _ in wanted]
    assert kinds.count("coloured noise") == 500 and len(set(wanted)) == 2000
    drawn = [false_alarms.bandwidth_of(*case) for case in wanted[:40]]
    assert sum(each is not None for each in drawn) == 10
    done = [{"kind": kind, "outcome": "silent", "processor_seconds": 1.0} for kind, _ in wanted]
    _, (row,) = false_alarms.figures(done)
    assert row["value"] == 0.0 and row["holds"]
    for each in done[:11]:
        each["outcome"] = "named"
    _, (row,) = false_alarms.figures(done)
    assert row["value"] == 0.0055 and not row["holds"]


def test_every_value_has_a_step_but_those_of_the_clock():
    assert tangent.step_of("controller.period") == 0.0
    assert tangent.step_of("object.x") == 0.2e-3
    assert tangent.step_of("mcp.moment_arm") == pytest.approx(0.02 * nominal()["mcp.moment_arm"])
    assert set(amplitudes()) <= set(SIZES)
