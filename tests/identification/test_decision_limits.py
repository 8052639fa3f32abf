"""Limits of a verdict: the noise that gains count in, and what a name may add to runs held out."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis.decision import allowed
from hannes.identification.diagnosis.noise_scale import estimated_variance_factor
from hannes.identification.diagnosis.trials import Trial, near, priced
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.simulation.catalogue import effects


@pytest.mark.parametrize(("per_bin", "noise"), [(0.5, 1.0), (0.8, 1.0), (1.5, 1.5)])
def test_gains_count_in_the_noise_that_is_there_but_no_less_than_assumed(per_bin, noise):
    baseline = SimpleNamespace(residual=np.zeros(100))
    assert estimated_variance_factor(baseline, 100.0 * per_bin) == pytest.approx(noise)


@pytest.mark.parametrize(
    ("delta_chi2", "most"), [(13.0, 4.0), (80.0, 4.0), (160.0, 8.0), (1e4, 12.0)]
)
def test_runs_held_out_may_fit_worse_by_a_share_of_the_gain_within_limits(delta_chi2, most):
    assert allowed(delta_chi2) == most


@pytest.mark.parametrize(
    ("left", "apart", "rivals"),
    [(-10.0, 30.0, 1), (-10.0, 45.0, 0), (40.0, 150.0, 1), (40.0, 2000.0, 0), (2000.0, 2000.0, 1)],
)
def test_a_law_that_leaves_little_has_no_rival_that_leaves_much_more(left, apart, rivals):
    """Of 100,000 explained, 2,000 less are 2 %: near where the best law is that inexact itself."""

    def trial(name, more):
        space = SimpleNamespace(effects=effects())
        point = SimpleNamespace(chi2=700.0 + left + more, residual=np.zeros(700), space=space)
        return Trial((name,), point, 1e5 - more)

    assert len(near(trial("capstan", 0.0), [trial("guide_load", apart)])) == rivals


def test_a_name_costs_more_beside_noise_that_is_simulated(investigated):
    best, gains = investigated.trials[0], {}
    for simulated in (True, False):
        noise = replace(investigated.baseline.noise, simulated_noise=simulated)
        baseline = replace(investigated.baseline, noise=noise)
        gains[simulated] = priced(baseline, best, 1.0).delta_chi2
    assert gains[False] - gains[True] == pytest.approx(SEARCH.simulated_price)
