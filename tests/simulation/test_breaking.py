"""Runs whose rates break, alone and among others: a named outcome, and no sample that is none.

Apart from other tests of the same functions, for they need the model with all effects.
"""

import numpy as np
import pytest
from catalogued import EVERYTHING, broken
from runs import WAYS, grasp

from hannes.core.errors import ComputationFailed
from hannes.simulation.batch.simulate_many import simulate_alike, simulate_many
from hannes.simulation.compiler import grasp_loop
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Outcome

COUNT = 7


@pytest.mark.parametrize("method", ["Rodas", "LSODA", "BDF", "Radau", "RK45"])
@pytest.mark.parametrize("how", WAYS)
def test_a_run_that_breaks_has_a_named_outcome(method, how):
    hand = broken(WAYS[how])
    found = simulate(hand, grasp(duration=0.1), method=method, effects=EVERYTHING.effects)
    assert found.outcome in (Outcome.NOT_FINITE, Outcome.SOLVER_GAVE_UP)
    assert found.message and found.message != "completed"
    assert found.time.size == found.states.shape[0] <= 51
    assert (found.time <= 0.0501).all()
    assert np.isfinite(found.states).all()
    with pytest.raises(ComputationFailed) as failure:
        found.require()
    text = str(failure.value)
    assert found.message in text and found.outcome.value in text and "\n" not in text


@pytest.mark.parametrize("method", ["Rodas", "LSODA", "BDF", "Radau", "RK45"])
def test_rates_that_are_not_finite_at_the_start_end_at_once(method):
    hand = broken(WAYS["not a number"], 0.0)
    found = simulate(hand, grasp(duration=0.1), method=method, effects=EVERYTHING.effects)
    assert found.outcome is Outcome.NOT_FINITE
    assert found.time.size == 0 and "finite" in found.message
    with pytest.raises(ComputationFailed, match=r"at 0\.0000 s"):
        found.require()


@pytest.mark.parametrize("cores", [1, 3])
def test_where_the_first_one_fails_each_takes_its_own_steps_on_any_cores(monkeypatch, cores):
    hand = EVERYTHING
    since = np.array([0.05, *np.ones(COUNT - 1)])
    table = {"breaking.way": 1.0, "breaking.since": since}
    table["motor.resistance"] = np.linspace(3.0, 3.3, COUNT)
    asked = {"channels": ("current",), "rtol": 1e-4, "effects": hand.effects}
    alone = list(simulate_many(hand, grasp(duration=0.3), table, **asked, progress=False))
    monkeypatch.setattr("hannes.simulation.batch.simulate_many._cores", lambda: cores)
    found = simulate_alike(hand, grasp(duration=0.3), table, **asked)
    assert found[0].outcome is not Outcome.COMPLETED
    for mine, theirs in zip(found[1:], alone[1:], strict=True):
        assert np.array_equal(mine["current"], theirs["current"])


def test_a_grasp_that_takes_many_times_the_steps_of_the_first_ends_there():
    """One once took half an hour: its limit lies far under that of any grasp."""
    hand, table = EVERYTHING, {"breaking.rattle": np.array([0.0, 1.0, 0.0])}
    asked = {"channels": ("current",), "rtol": 1e-4, "effects": hand.effects}
    found = simulate_alike(hand, grasp(duration=0.3), table, **asked)
    assert [each.outcome for each in found[::2]] == [Outcome.COMPLETED] * 2
    assert found[1].outcome is Outcome.SOLVER_GAVE_UP and "Not near" in found[1].message
    most = grasp_loop.APART * found[0].cost.jacobians
    assert found[1].cost.jacobians <= most + grasp_loop.RUN
