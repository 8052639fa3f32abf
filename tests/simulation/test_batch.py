"""Batches: the bits of one-at-a-time, in order, whatever the workers; failures, stops, memory."""

import itertools
import os
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from runs import BREAK, grasp
from scipy.integrate import solve_ivp

from hannes.control.firmware_memory import MEMORY
from hannes.core.errors import BadInput, ComputationFailed
from hannes.simulation.batch import chunks
from hannes.simulation.batch.simulate_many import simulate_alike, simulate_many
from hannes.simulation.compiled_call import ended
from hannes.simulation.compiler.grasp_loop import LONGEST, TOO_MANY
from hannes.simulation.hand.hand import Hand
from hannes.simulation.integrate import tolerances
from hannes.simulation.rodas.scipy_solver import Rodas
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Outcome

CHANNELS = ("current", "force", "phalanx_force", "joint_angle", "motor_speed")
COUNT = 7
COLUMNS = {
    "object.stiffness": np.linspace(800.0, 9000.0, COUNT),
    "mcp.moment_arm": np.linspace(9e-3, 11e-3, COUNT),
    "index.rest_mcp": np.linspace(0.2, 0.25, COUNT),
}
SIZES = {"object.radius": np.linspace(0.02, 0.03, COUNT), "object.friction": 0.3}


def rows(columns, count=COUNT):
    """The values of each grasp."""
    spread = {name: np.broadcast_to(column, count) for name, column in columns.items()}
    return [{name: float(c[k]) for name, c in spread.items()} for k in range(count)]


def same(found, run):
    """Return whether a grasp has the bits of a trajectory."""
    equal = [np.array_equal(found[name], run[name]) for name in CHANNELS]
    return all(equal) and np.array_equal(found.time, run.time)


def test_progress_counts_every_grasp(monkeypatch):
    calls = []

    class Bar:
        def __init__(self, *, total, disable, **how):
            calls.append((total, disable))

        def update(self, count):
            calls.append(count)

        def close(self):
            calls.append("closed")

    monkeypatch.setattr("tqdm.auto.tqdm", Bar)
    given = Hand(), grasp(duration=0.05), COLUMNS
    list(simulate_many(*given, channels=CHANNELS, workers=2, progress=True))
    assert calls[0] == (COUNT, False) and calls[-1] == "closed" and sum(calls[1:-1]) == COUNT


# --- the same bits ----------------------------------------------------------------------------


@pytest.mark.parametrize("controller", ["continuous", "sampled"])
@pytest.mark.parametrize("columns", [COLUMNS, SIZES], ids=["packed at once", "by sections"])
def test_columns_give_the_bits_of_simulate(controller, columns):
    hand, experiment = Hand(), grasp(duration=0.7, controller=controller)
    singles = [simulate(hand, replace(experiment, values=row), rtol=1e-3) for row in rows(columns)]
    assert singles[0]["force"].max() > 1.0
    for workers in (1, 2, 3):
        found = simulate_many(
            hand, experiment, columns, rtol=1e-3, channels=CHANNELS, workers=workers
        )
        for number, (mine, single) in enumerate(zip(found, singles, strict=True)):
            assert mine.number == number and same(mine, single)
            assert replace(mine.cost, seconds=0.0) == replace(single.cost, seconds=0.0)


@pytest.mark.parametrize("most", [1, 2, 5])
def test_windows_of_any_size_give_the_same_bits(monkeypatch, most):
    expected = list(simulate_many(Hand(), grasp(duration=0.4), COLUMNS, workers=1))
    monkeypatch.setattr(chunks, "MOST", most)
    found = simulate_many(Hand(), grasp(duration=0.4), COLUMNS, workers=2)
    for mine, theirs in zip(found, expected, strict=True):
        assert np.array_equal(mine["force"], theirs["force"])


NEARBY = {  # of parameters that do much and little
    "motor.resistance": 3.1 * np.array([1.0, 1.01, 1.0]),
    "mcp.viscous_friction": 1.07e-3 * np.array([1.0, 1.0, 1.02]),
}


def changes(runs):
    """What the current of each but the first differs by from it, (rows, samples) [A]."""
    first, *others = (each["current"] for each in runs)
    return np.array(others) - first


def test_grasps_by_the_steps_of_the_first_differ_smoothly():
    hand, experiment = Hand(), grasp(duration=0.7)
    exact = changes(simulate_many(hand, experiment, NEARBY, rtol=1e-9, progress=False))
    asked = {"channels": ("current",), "rtol": 1e-4}
    alone = list(simulate_many(hand, experiment, NEARBY, **asked, progress=False))
    alike = simulate_alike(hand, experiment, NEARBY, **asked)
    assert np.array_equal(alike[0]["current"], alone[0]["current"])
    assert [each.number for each in alike] == [0, 1, 2]

    def off(runs):
        error = changes(runs) - exact
        return np.sqrt(np.mean(error**2, axis=1) / np.mean(exact**2, axis=1))

    assert (off(alike) < 0.01).all()
    assert (off(alike) < 0.2 * off(alone)).all(), (off(alike), off(alone))


def test_a_grasp_far_from_the_first_takes_steps_of_its_own_between():
    far = {"object.stiffness": np.array([800.0, 9000.0])}
    asked = {"channels": ("force",), "rtol": 1e-4}
    exact = list(simulate_many(Hand(), grasp(), far, rtol=1e-7, progress=False))[1]
    found = simulate_alike(Hand(), grasp(), far, **asked)[1]
    assert found["force"] == pytest.approx(exact["force"], abs=1e-3 * exact["force"].max())


def test_the_controller_is_the_continuous_one_whatever_the_experiment_says():
    asked, smooth = {"channels": ("current",), "rtol": 1e-4}, grasp(duration=0.2)
    sampled = replace(smooth, controller="sampled")
    found = [simulate_alike(Hand(), each, NEARBY, **asked) for each in (smooth, sampled)]
    assert np.array_equal(*([run["current"] for run in each] for each in found))


@pytest.mark.parametrize("cores", [1, 2, 5])
def test_grasps_by_the_first_ones_steps_have_the_same_bits_on_any_cores(monkeypatch, cores):
    asked = {"channels": ("force",), "rtol": 1e-3}
    expected = simulate_alike(Hand(), grasp(duration=0.4), COLUMNS, **asked)
    monkeypatch.setattr("hannes.simulation.batch.simulate_many._cores", lambda: cores)
    found = simulate_alike(Hand(), grasp(duration=0.4), COLUMNS, **asked)
    for mine, theirs in zip(found, expected, strict=True):
        assert mine.number == theirs.number
        assert np.array_equal(mine["force"], theirs["force"])


def pairs():
    """Hands and experiments of several kinds, without end."""
    slow, soft = Hand(), Hand().with_values({"motor.resistance": 4.0})
    for k in itertools.count():
        shape = (None, "sphere", "cylinder")[k % 3]
        controller = ("continuous", "sampled")[k // 2 % 2]
        experiment = grasp(shape, 0.3 + 0.1 * (k % 2), 500.0, controller)
        yield (soft if k % 5 else slow), experiment


@pytest.mark.parametrize("workers", [1, 3])
def test_pairs_give_the_bits_of_simulate(workers):
    """A generator without end is read only as far as it is needed."""
    found = simulate_many(pairs(), channels=CHANNELS, workers=workers)
    for number, pair in enumerate(itertools.islice(pairs(), 40)):
        mine = next(found)
        assert mine.number == number and same(mine, simulate(*pair))


def test_sampling_is_that_of_a_resampled_experiment():
    found = next(simulate_many(Hand(), grasp(), sampling=100.0))
    assert np.array_equal(found["force"], simulate(Hand(), grasp(sampling=100.0))["force"])
    assert found.time.size == found["force"].size == 116


def test_the_compiled_loop_takes_the_steps_of_solve_ivp():
    hand, experiment = Hand(), grasp()
    posed = hand.with_values(experiment.overrides())
    compiled, knots = posed.compiled(), experiment.reference.knots
    problem = compiled.problem(posed.vector("cylinder"), knots, np.zeros(MEMORY))
    found = solve_ivp(
        None,
        (0.0, experiment.duration),
        posed.rest(compiled),
        method=Rodas,
        t_eval=experiment.times,
        rtol=1e-3,
        atol=tolerances(compiled, 1e-3),
        problem=problem,
        run=100,
        kinks=knots[0],
        max_step=LONGEST,
    )
    assert np.array_equal(found.y.T, simulate(hand, experiment, rtol=1e-3).states)


# --- failures ---------------------------------------------------------------------------------

WAYS = np.array([0.0, 0.0, 1.0, 0.0, 2.0, 0.0])  # the third and the fifth break at 0.05 s


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["continuous", "sampled"])
def test_a_grasp_that_breaks_has_a_named_outcome_and_leaves_the_others_whole(controller):
    hand, experiment = Hand().with_effects(BREAK), grasp(duration=0.1, controller=controller)
    whole = simulate(Hand(), experiment)
    found = list(simulate_many(hand, experiment, {"breaking.way": WAYS}, channels=CHANNELS))
    for mine, way in zip(found, WAYS, strict=True):
        if way == 0.0:
            assert same(mine.require(), whole)
            continue
        assert mine.outcome in (Outcome.NOT_FINITE, Outcome.SOLVER_GAVE_UP)
        assert mine.time.size == mine["force"].size <= 51 and np.isfinite(mine["force"]).all()
        single = simulate(hand.with_values({"breaking.way": way}), experiment)
        assert same(mine, single) and mine.message == single.message
        with pytest.raises(ComputationFailed, match=f"grasp {mine.number}: .* at 0.0"):
            mine.require()


def test_a_grasp_of_too_many_steps_is_named():
    outcome, message = ended(np.array([0, 0, 0, 0, TOO_MANY, 0]))
    assert outcome is Outcome.SOLVER_GAVE_UP and "1000000 steps" in message


REFUSED = {
    "stiffness": ({"values": {"object.stifness": 1.0}}, "object.stiffness"),
    "bounds": ({"values": {"object.stiffness": [1e3, -1.0]}}, "lower bound"),
    "text": ({"values": {"object.stiffness": "8344 N/m"}}, "expected numbers in SI units"),
    "not finite": ({"values": {"object.stiffness": [1e3, np.nan]}}, "finite"),
    "lengths": ({"values": {"object.x": [0.0, 0.0], "object.y": [0.0] * 3}}, "one length"),
    "table": ({"values": {"object.x": np.zeros((2, 2))}}, "one length"),
    "channel": ({"channels": ("forse",)}, "force"),
    "rtol": ({"rtol": 2.0}, "rtol"),
    "workers": ({"workers": 0}, "workers"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_is_one_line(case):
    given, said = REFUSED[case]
    with pytest.raises(BadInput, match=said) as refusal:
        list(simulate_many(Hand(), grasp(duration=0.01), **given))
    assert "\n" not in str(refusal.value)


def test_what_does_not_pair_is_refused():
    with pytest.raises(BadInput, match="expected an experiment"):
        simulate_many(Hand())
    with pytest.raises(BadInput, match="alone"):
        simulate_many([(Hand(), grasp())], grasp())
    with pytest.raises(BadInput, match="pair 0"):
        list(simulate_many([Hand()]))
    found = next(simulate_many(Hand(), grasp(duration=0.01)))
    with pytest.raises(BadInput, match="not asked for"):
        found["duty"]


# --- stops and memory -------------------------------------------------------------------------


def test_no_rows_give_no_grasps():
    assert list(simulate_many(Hand(), grasp(), {"object.stiffness": []})) == []
    assert list(simulate_many([])) == []
    empty = {"object.stiffness": []}
    assert simulate_alike(Hand(), grasp(), empty, channels=("force",), rtol=1e-4) == []


def test_threads_end_with_the_loop():
    before = threading.active_count()
    found = simulate_many(pairs(), workers=3)
    next(found)
    assert threading.active_count() > before
    found.close()
    assert threading.active_count() == before


def test_memory_does_not_grow_with_the_batch():
    """A grasp of 60 rows with 11,501 samples is 5.5 MB, 96 of them 530: a window holds what fits.

    How many windows are in flight at once is the scheduler's choice, so only the limit is held.
    """
    tracemalloc.start()
    for found in simulate_many(
        Hand(),
        grasp(duration=0.115, sampling=1e5),
        {"object.stiffness": np.linspace(800.0, 900.0, 96)},
        channels=["joint_angle", "joint_speed", "phalanx_force"] * 2,
        workers=2,
    ):
        assert found["joint_angle"].shape == (11_501, 10)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2e8


ENDLESS = """
import itertools
from hannes import Hand, simulate_many
from runs import grasp
for found in simulate_many(zip(itertools.repeat(Hand()), itertools.repeat(grasp()))):
    print(found.number, flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_ctrl_c_stops_it_cleanly():
    running = subprocess.Popen(
        [sys.executable, "-c", ENDLESS],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert running.stdout.readline() == "0\n"
    time.sleep(0.2)
    asked = time.monotonic()
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=20)
    assert time.monotonic() - asked < 2.0
    assert running.returncode == -signal.SIGINT
    assert said.rstrip().endswith("KeyboardInterrupt") and said.count("Traceback") == 1
