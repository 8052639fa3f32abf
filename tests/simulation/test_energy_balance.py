"""The energy ledger closes: whatever goes into the motor is found again, part by part."""

import functools
import json
from dataclasses import replace

import numpy as np
import pytest
from runs import grasp, reference

from hannes.commands.run import run
from hannes.core.errors import BadInput
from hannes.simulation.energy_balance import MOST, account, energy_ledger
from hannes.simulation.experiment.load import load
from hannes.simulation.experiment.shipped import names
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate

CLOSE = ((0.0, 0.0), (1.4, 23.0))  # winds all the wire up to the stops
CASES = {
    "void closure": (grasp(None, 0.6), {}),
    "closure to the stops": (
        replace(grasp(None), reference=reference(CLOSE), duration=1.6),
        {"position_pid.limit": 1.5},
    ),
    "dynamometer": (grasp(), {}),
    "soft sphere": (grasp("sphere", stiffness=800.0, radius=0.035), {}),
    "prism": (grasp("prism", radius=0.005, half_x=0.02, half_y=0.02), {}),
    "gravity in the fingers' plane": (grasp(), {"gravity.x": 3.0, "gravity.y": -9.3}),
    "sampled controller": (grasp(controller="sampled"), {}),
}
LOST = (
    "copper",
    "gear_friction",
    "cart_friction",
    "joint_friction",
    "contact_normal",
    "contact_tangential",
)


@functools.cache
def finely(case):
    """The case's trajectory at 20 kHz."""
    experiment, values = CASES[case]
    experiment = replace(experiment, sampling=20_000.0, values=values)
    return simulate(Hand(), experiment, rtol=1e-6).require()


@pytest.mark.parametrize("case", CASES)
def test_ledger_closes(case):
    run = finely(case)
    ledger = energy_ledger(run)
    assert abs(ledger["residual"]) < 1e-4
    assert all(ledger[name] >= -1e-9 for name in LOST)
    touched = run["force"].max() > 0.0
    assert (ledger["contact_normal"] > 0.0) == touched == (ledger["contact_tangential"] > 0.0)
    if "stops" in case:
        assert (run["joint_angle"][-1] > 1.0).all() and ledger["stop"] > 1e-3
    if "gravity" in case:
        assert abs(ledger["gravity"]) > 1e-4


@pytest.mark.parametrize("case", CASES)
def test_stored_energies_are_functions_of_the_state(case):
    """Springs, gravity and taut wires hold what their powers brought, from the states alone."""
    run, hand = finely(case), Hand().with_values(CASES[case][1])
    ledger, value = energy_ledger(run), hand.parameters
    allowed = 1e-5 * ledger["electrical"]
    bend = run["joint_angle"][-1] - run["joint_angle"][0]
    spring = sum(
        value[f"{name}.spring_preload"] * bend[at::2].sum()
        + 0.5 * value[f"{name}.spring_stiffness"] * (bend[at::2] ** 2).sum()
        for at, name in enumerate(("mcp", "pip"))
    )
    assert ledger["spring"] == pytest.approx(spring, abs=allowed)
    if "slack" not in case:
        leader = 0.5 * value["leader.stiffness"] * max(run["leader_stretch"][-1], 0.0) ** 2
        follower = 0.5 * (run["follower_tension"][-1] ** 2).sum() / value["follower.stiffness"]
        # the wires' damping share of the last tension is of no account at rest
        assert ledger["wire_elastic"] == pytest.approx(leader + follower, abs=20 * allowed)


# Those with a floating object are in test_floating_object.py: one process compiles their model.
@pytest.mark.parametrize("name", [each for each in names() if "floating" not in each])
def test_ledger_closes_over_shipped_experiments(name):
    found = load(name)
    if not isinstance(found, list):
        pytest.skip("needs no simulation")
    for variant in found:
        experiment = replace(variant.experiment, sampling=20_000.0)
        run = simulate(variant.hand, experiment, rtol=1e-6).require()
        assert abs(energy_ledger(run)["residual"]) < 1e-3


def test_an_account_samples_finely_whatever_the_experiment_does():
    ledger = account(Hand(), grasp(duration=0.5, sampling=100.0), rtol=1e-6)
    assert abs(ledger["residual"]) < 1e-4 and ledger["copper"] > 0.0


def test_an_account_of_hours_is_refused():
    with pytest.raises(BadInput, match=r"at most 50 s, this one takes 3600 s"):
        account(Hand(), grasp(duration=3600.0))
    assert MOST == 200_000


def test_run_writes_the_ledger_and_names_its_cost(tmp_path, capsys):
    summary = run("void-closure", tmp_path / "out")
    (row,) = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))["runs"]
    assert row["energy"] == summary["runs"][0]["energy"]
    assert abs(row["energy"]["residual"]["value"]) < 1e-3
    assert row["energy"]["copper"]["unit"] == "J" and row["energy"]["copper"]["value"] > 0.0
    assert set(row["cost"]) == {"evaluations", "jacobians", "jacobian", "smooth_parts", "seconds"}
    assert row["cost"]["jacobian"] == "structured"
    assert row["cost"]["smooth_parts"] == 3  # the reference rises, falls and rests


def test_run_says_why_there_is_no_ledger(tmp_path):
    still = """duration = "10 ms"
    [reference]
    kind = "ramp"
    points = [["0 s", "0 rad"], ["1 s", "0 rad"]]"""
    (tmp_path / "still.toml").write_text(still, encoding="utf-8")
    (row,) = run(tmp_path / "still.toml", tmp_path / "out")["runs"]
    assert "takes energy" in row["energy"]["reason"]


def test_coarse_samples_are_refused():
    run = simulate(Hand(), grasp(duration=0.02))
    with pytest.raises(BadInput, match=r"4000 Hz or more.*sampling.*1000 Hz"):
        energy_ledger(run)


def test_a_run_without_energy_is_refused():
    rest = replace(grasp(None, 0.01), reference=reference(((0.0, 0.0), (1.0, 0.0))))
    run = simulate(Hand(), replace(rest, sampling=20_000.0))
    assert np.abs(run["current"]).max() < 1e-12
    with pytest.raises(BadInput, match="takes energy"):
        energy_ledger(run)
