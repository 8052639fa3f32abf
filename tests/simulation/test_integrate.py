"""A continuous simulation goes through scipy's solve_ivp: what that returns is the trajectory."""

import numpy as np
import pytest
import scipy.integrate
from runs import grasp

from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate

SHORT = 0.05  # s


@pytest.fixture
def solved(monkeypatch):
    """Results of scipy's solve_ivp, as it is called."""
    results, original = [], scipy.integrate.solve_ivp

    def noted(*arguments, **options):
        results.append((original(*arguments, **options), options))
        return results[-1][0]

    monkeypatch.setattr(scipy.integrate, "solve_ivp", noted)
    return results


@pytest.mark.parametrize("method", ["Rodas", "LSODA"])
def test_the_states_are_what_solve_ivp_returned(solved, method):
    found = simulate(Hand(), grasp(duration=SHORT), method=method).require()
    result, options = solved[-1]
    assert np.array_equal(found.states, result.y.T)
    assert found.cost.evaluations == result.nfev > 0
    named = options["method"]
    assert named == "LSODA" if method == "LSODA" else issubclass(named, scipy.integrate.OdeSolver)


def test_what_solve_ivp_returns_is_not_computed_again(monkeypatch):
    original = scipy.integrate.solve_ivp

    def shifted(*arguments, **options):
        result = original(*arguments, **options)
        result.y = result.y + 1.0
        return result

    plain = simulate(Hand(), grasp(duration=SHORT)).require()
    monkeypatch.setattr(scipy.integrate, "solve_ivp", shifted)
    assert np.array_equal(simulate(Hand(), grasp(duration=SHORT)).states, plain.states + 1.0)
