"""Campaigns of the truth: what they hold, what they hide, and that hannes can replay them."""

import json
import time
import tomllib

import numpy as np
import pytest

from benchmarks.truth import NOMINAL, nominal
from benchmarks.truth import closures as closures_module
from benchmarks.truth.bench import CURRENT, FORCE, SUPPLY, SUPPLY_STEP
from benchmarks.truth.campaign import Spread, main, make
from benchmarks.truth.fitness import fit
from benchmarks.truth.parameters import flat, named
from benchmarks.truth.protocol import DYNAMOMETER, PAPER, POOR, PROTOCOLS, RICH, Condition, Protocol
from benchmarks.truth.scatter import EXACT, normal, run_scatter, scatter
from hannes.campaigns.campaign_file import read_campaign

QUICK = Protocol((Condition("void", ((0.0, 0.0), (0.1, 1.5)), 2),), RICH)
NONE = Spread(0.0, "normal", 0.0, 0.0)


def written(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_same_seed_same_bytes(tmp_path):
    for name, seed in (("one", 1), ("two", 1), ("other", 2)):
        make(QUICK, seed, {"leader_slack.length": 3e-3}).write(tmp_path / name)
    one = written(tmp_path / "one")
    assert one == written(tmp_path / "two")
    assert one["01_void.h5"] != written(tmp_path / "other")["01_void.h5"]
    assert one["01_void.h5"] != one["02_void.h5"]


@pytest.mark.parametrize("experiment", ["", "void-closure"])
def test_only_the_sealed_answer_holds_what_is_hidden(tmp_path, experiment):
    make(QUICK, 1, {"leader_slack.length": 3e-3}).write(tmp_path, experiment)
    files = written(tmp_path)
    sealed = json.loads(files.pop("sealed/answer.json"))
    assert sealed["effects"] == {"leader_slack": {"length": 3e-3}}
    for name, content in files.items():
        assert b"slack" not in content and b"sealed" not in content, name
    make(QUICK, 1).write(tmp_path / "taut", experiment)
    taut = written(tmp_path / "taut")
    assert taut["campaign.toml"] == files["campaign.toml"]
    assert json.loads(taut["sealed/answer.json"])["hand"] == sealed["hand"]


def test_a_campaign_states_how_far_its_hand_may_be_off(tmp_path):
    spread = Spread(0.02, "normal", 0.005, 0.2e-3)
    for assumed, first in ((None, "2 %"), (spread.times(0.5), "1 %"), (spread.times(2.0), "4 %")):
        made = make(QUICK, 1, assumed=assumed)
        made.write(tmp_path)
        table = tomllib.loads((tmp_path / "campaign.toml").read_text())["diagnose"]
        assert table["scatter"] == first
        assert table.keys() == {"scatter", "run_scatter", "start_time"}
        assert made.answer["spread"] == vars(spread)
    assert table == {"scatter": "4 %", "run_scatter": "1 %", "start_time": "0.4 ms"}
    read_campaign(tmp_path / "campaign.toml")


def test_answers_hold_the_hand_and_every_run_by_the_librarys_names():
    from hannes.simulation.hand.hand import Hand

    answer = make(QUICK, 1).answer
    known = Hand().parameters
    assert set(answer["hand"]) <= set(known)
    assert set(answer["hand"]) == set(flat(NOMINAL))
    assert [run["file"] for run in answer["runs"]] == ["01_void", "02_void"]
    for run in answer["runs"]:
        assert set(run["parameters"]) <= set(known)
        assert 0.0 < abs(run["late_s"]) < 1e-3


def test_protocols_have_the_runs_and_channels_they_promise():
    poor, rich = PROTOCOLS["poor"], PROTOCOLS["rich"]
    assert [(c.name, c.repeats) for c in poor.conditions] == [("void", 6), ("dynamometer", 6)]
    assert all(c.points == PAPER for c in poor.conditions)
    assert len(rich.runs) == 16
    assert all(c.repeats >= 2 for c in rich.conditions)
    assert set(RICH) - set(POOR) == {"duty_1", "supply_V"}


def test_a_poor_campaign_logs_what_its_bench_sees():
    made = make("poor", 1)
    assert len(made.recordings) == 12
    for name, recording in made.recordings.items():
        forces = ("force", "sensor") if made.conditions[name] == "dynamometer" else ()
        assert recording.names == ("reference", "position", "current", *forces)
        counts = recording["position"] * 4096 / (2 * np.pi)
        np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
        assert recording.plant == "hand" and recording.source == "measured"
        assert "Made by benchmarks.truth" in recording.experiment


def test_sensors_are_as_noisy_as_they_say():
    made = make(Protocol((Condition("still", ((0.0, 0.0), (4.0, 0.0)), 1),), RICH), 1, spread=NONE)
    recording = made.recordings["01_still"]
    assert np.std(recording["supply"]) == pytest.approx(
        np.hypot(SUPPLY, SUPPLY_STEP / 12**0.5), rel=0.1
    )
    assert np.std(recording["current"]) == pytest.approx(CURRENT, rel=0.2)


@pytest.fixture(scope="module")
def unscattered():
    return make("rich", 3, spread=NONE)


def test_hannes_replays_an_unscattered_hand_down_to_the_sensors(unscattered, tmp_path):
    unscattered.write(tmp_path)
    campaign = read_campaign(tmp_path / "campaign.toml")
    one_of_each = {entry.condition: entry.recording for entry in campaign.entries}
    assert len(one_of_each) == len(PROTOCOLS["rich"].conditions)
    # Half the last digit and one count of the encoder on top of the noise.
    floor = {"position": 2e-3, "current": 1.2 * CURRENT, "duty": 3e-3}
    floor |= {"force": 1.5 * FORCE, "sensor": 1.5 * FORCE}
    for condition, recording in one_of_each.items():
        simulated = campaign.plant.simulate({}, recording)
        for name, most in floor.items():
            if name in recording:
                gap = np.sqrt(np.mean((simulated[name] - recording[name]) ** 2))
                assert gap < most, (condition, name)


def test_a_rich_campaign_costs_seconds(unscattered):
    start = time.process_time()  # compiled by now
    make("rich", 4)
    assert time.process_time() - start < 5.0  # 1.4 s on a quiet core


def test_hands_scatter_as_asked_and_firmware_does_not():
    hands = [scatter(NOMINAL, np.random.default_rng(s), 0.02) for s in range(400)]
    for name, value in NOMINAL.items():
        drawn = np.array([hand[name] for hand in hands]).reshape(400, -1)
        if name in ("object.x", "object.y"):
            assert np.std(drawn) == pytest.approx(0.2e-3, rel=0.15)
        elif name.startswith(EXACT) or not np.any(value):
            assert np.all(drawn == np.reshape(value, -1)), name
        else:
            shares = drawn / np.reshape(value, -1) - 1.0
            assert np.std(shares) == pytest.approx(0.02, rel=0.2), name
            assert np.abs(shares).max() <= 0.05
    uniform = [scatter(NOMINAL, np.random.default_rng(s), 0.2, "uniform") for s in range(200)]
    shares = np.array([hand["motor.resistance"] for hand in uniform]) / 3.084 - 1.0
    assert -0.2 <= shares.min() < -0.18 and 0.18 < shares.max() <= 0.2


def test_runs_scatter_in_what_varies_from_run_to_run():
    runs = [run_scatter(nominal(), np.random.default_rng(s), 0.005, 0.2e-3) for s in range(400)]
    moved = {name for values, _ in runs for name, value in values.items() if value != NOMINAL[name]}
    assert {"motor.dry_friction", "mcp.spring_preload", "object.x", "supply.voltage"} <= moved
    assert not any(name.startswith(("fingers.", "encoder.", "position_pid.")) for name in moved)
    spread = np.std([values["motor.dry_friction"] for values, _ in runs]) / 4.7e-3
    assert spread == pytest.approx(0.005, rel=0.15)
    assert np.std([late for _, late in runs]) == pytest.approx(0.2e-3, rel=0.15)


def test_far_draws_are_drawn_again():
    assert np.abs(normal(np.random.default_rng(0), 5000)).max() <= 2.5


@pytest.mark.parametrize(
    "change",
    [
        {"motor.resistance": 6.0},  # saturates
        {"position_pid.proportional": 0.005},  # hardly grasps
        {"index.rest_mcp": 0.9},  # stands in the object
        {"mcp.coulomb_friction": 0.08},  # does not open again
    ],
)
def test_hands_that_are_none_are_refused(change):
    assert fit(nominal())
    assert not fit(named({**NOMINAL, **change}))


def test_hands_scattered_by_a_fifth_still_grasp():
    for seed in range(4):
        answer = make(QUICK, seed, spread=Spread(0.2, "uniform")).answer
        assert fit(named(answer["hand"]))


def test_a_wire_that_creeps_keeps_its_length_from_run_to_run():
    plan = Protocol((Condition("dynamometer", PAPER, 3, DYNAMOMETER, sensor=True),), POOR)
    runs = make(plan, 1, {"wire_creep.rate": 5e-6}, NONE).answer["runs"]
    crept = [run["crept_m"] for run in runs]
    assert crept[0] == 0.0
    assert crept[2] == pytest.approx(2 * crept[1], rel=0.05)
    assert 1e-4 < crept[1] < 1e-3


@pytest.mark.parametrize(
    "words",
    [
        ["--hide", "leader_slack.lenght=3 mm"],
        ["--hide", "leader_slack.length=3 kg"],
        ["--hide", "leader_slack.length"],
        ["--hide", "leader_slack.length=nan m"],
        ["--hide", "leader_slack.length=1 mm", "--hide", "capstan.drag=0.1"],
        ["--timing", "3 mm"],
        ["--hand", "nowhere.toml"],
        ["--hand", "hand.toml"],
    ],
)
def test_bad_input_is_one_line_and_status_2(words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    hand = '[parameters]\n"motor.resistence" = "3 ohm"\n'
    (tmp_path / "hand.toml").write_text(hand, encoding="utf-8")
    assert main(["--out", "campaign", *words]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "campaign").exists()


def test_closures_are_a_campaign_in_csv(tmp_path, capsys):
    assert closures_module.main(["--out", str(tmp_path), "--slack", "3 mm", "--runs", "1"]) == 0
    files = set(written(tmp_path))
    shown = {"hand.toml", "campaign.toml", "closure.toml", "sealed/answer.json"}
    assert files == {"01_void.csv"} | shown
    (entry,) = read_campaign(tmp_path / "campaign.toml").entries
    assert 'controller = "sampled"' in entry.recording.experiment
    assert entry.recording.names == ("reference", "position", "current", "duty", "supply")
    assert closures_module.main(["--out", str(tmp_path), "--slack", "3 kg"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
