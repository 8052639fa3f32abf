"""Steps of a fit keep to bounds, and effects that bias the baseline are started globally."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from sled import STIFFER, TURBULENCE, Sled, recordings

from hannes.identification.diagnosis import as_given, single_effects
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.gauss_newton import newton_step
from hannes.identification.diagnosis.global_starts import absorbed_by_baseline
from hannes.identification.diagnosis.score_test import screened
from hannes.identification.diagnosis.settings import Settings


def point(columns, residual, x, low, high):
    """A made-up quadratic chi-squared without priors."""
    space = SimpleNamespace(low=np.array(low), high=np.array(high))
    return SimpleNamespace(
        space=space,
        x=np.array(x),
        active=np.arange(len(x)),
        prior=np.zeros(len(x)),
        hessian=columns @ columns.T,
        gradient=columns @ residual,
    )


def rise(at, step):
    """What a step adds to the misfit."""
    return float(step @ at.hessian @ step - 2.0 * step @ at.gradient)


def test_two_sizes_that_do_nearly_the_same_go_downhill_where_one_would_go_below_its_bound():
    time = np.linspace(0.0, 1.0, 50)
    columns = np.array([np.sin(3.0 * time), np.sin(3.0 * time) + 0.05 * time])
    at = point(columns, 2.0 * columns[0] - 1.0 * columns[1], [0.1, 1e-9], [0.0, 0.0], [9.0, 9.0])
    free = np.linalg.solve(at.hessian, at.gradient)
    assert rise(at, np.clip(at.x + free, 0.0, 9.0) - at.x) > 0.0  # cut off afterwards
    step = newton_step(at)
    assert rise(at, step) < 0.0
    assert (at.x + step)[1] == 0.0


@pytest.mark.parametrize("seed", range(20))
def test_a_step_is_the_least_squares_within_bounds(seed):
    rng = np.random.default_rng(seed)
    columns, residual = rng.standard_normal((4, 30)), 3.0 * rng.standard_normal(30)
    x = rng.uniform(0.0, 0.2, 4)
    at = point(columns, residual, x, np.zeros(4), np.full(4, 0.3))
    step = newton_step(at)
    assert (x + step >= -1e-12).all() and (x + step <= 0.3 + 1e-12).all()
    best = lsq_linear(columns.T, residual, (-x, 0.3 - x)).x
    assert rise(at, step) == pytest.approx(rise(at, best), rel=1e-4)


def test_what_is_at_a_bound_and_pushed_out_stays():
    columns = np.eye(2)
    at = point(columns, np.array([-1.0, 0.5]), [0.0, 0.0], [0.0, 0.0], [1.0, 1.0])
    assert newton_step(at) == pytest.approx([0.0, 0.5], abs=1e-5)


@pytest.fixture(scope="module")
def baseline():
    """Of a sled with hidden turbulence; what stiffens the spring is a value that it has."""
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    effects = [TURBULENCE, STIFFER]
    return search_effects(Sled(), entries, effects, Settings(0.02, 0.005), 0).baseline


def test_a_baseline_absorbs_what_its_parameters_can_do(baseline):
    guesses = {each.effect: each for each in screened(baseline, ["turbulence", "stiffer"])}
    assert absorbed_by_baseline(baseline, guesses["stiffer"])
    assert not absorbed_by_baseline(baseline, guesses["turbulence"])


def test_what_the_baseline_absorbs_starts_in_the_nominal_machine(monkeypatch):
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    asked = []
    monkeypatch.setattr(as_given, "global_fits", lambda *_: {})
    monkeypatch.setattr(
        single_effects, "absorbed_by_baseline", lambda baseline, guess: guess.delta_chi2 > 0.0
    )
    monkeypatch.setattr(
        single_effects,
        "fits_from_nominal",
        lambda nominal, baseline, names, *_: asked.append(names) or {},
    )
    search_effects(Sled(), entries, [TURBULENCE], Settings(0.02, 0.005), 0)
    assert asked[0] == ["turbulence"]
