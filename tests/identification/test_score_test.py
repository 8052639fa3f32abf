"""Screening of effects: guesses, their signatures, and the shapes that are tried."""

from dataclasses import replace

import numpy as np
import pytest
from sled import HARDENING, KNOWN, TURBULENCE, WAVES, WAVES_OF_23, Sled, found, recordings

from hannes.core.kernels.jit import plain
from hannes.identification.confusability import confusable, text
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.multistart import started_at, started_at_guess
from hannes.identification.diagnosis.score_test import (
    _twins,
    cosine_similarity,
    projected,
    screened,
    shapes,
)
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.simulation.catalogue import effects


def test_a_guess_agrees_with_the_refit_where_an_effect_is_small():
    entries = [e for e in recordings(1, ((TURBULENCE, 0.5),)) if e.role != "show"]
    small = search_effects(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    guess = next(each for each in small.guesses if each.effect == "turbulence")
    trial = next(each for each in small.trials if each.effects == ("turbulence",))
    assert guess.delta_chi2 == pytest.approx(trial.delta_chi2 * small.variance_factor, rel=0.1)
    again = {g.effect: g.delta_chi2 for g in screened(trial.point, ["hardening"])}
    assert again["hardening"] < SEARCH.name_limit


def test_what_parameters_can_do_is_no_signature_of_an_effect(investigated):
    baseline = investigated.baseline
    row = baseline.jacobian[:1]
    _, hessian = projected(baseline, row)
    assert hessian[0, 0] < 1.01  # as much as the given value's own spread leaves of it
    assert cosine_similarity(baseline, row, row) == pytest.approx(1.0, abs=1e-3)


def test_a_phase_and_its_opposite_are_tried_by_one_mark():
    ripple = effects()["torque_ripple"]
    (quarter,) = [each for each in shapes(ripple) if list(each.values()) == [3.0, np.pi / 2.0]]
    (same, as_is), (opposite, turned) = _twins(ripple, quarter)
    assert (same, as_is, turned) == (quarter, 1.0, -1.0)
    assert opposite["torque_ripple.phase"] == pytest.approx(1.5 * np.pi)
    kernel = plain(ripple.terms[0].kernel)
    signatures = [kernel(0.7, 1e-3, *each.values()) for each in (quarter, opposite)]
    assert signatures[1] == pytest.approx(-signatures[0], rel=1e-12)


def test_a_guess_that_goes_too_far_is_begun_at_a_share():
    entries = [e for e in recordings(3, ((HARDENING, 900.0),)) if e.role != "show"]
    found = search_effects(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    baseline, (guess,) = found.baseline, [g for g in found.guesses if g.effect == "hardening"]
    far = replace(guess, x=20.0 * guess.x)
    whole, part = started_at(baseline, far.places, far.x), started_at_guess(baseline, far)
    assert part.chi2 < 0.5 * whole.chi2
    assert part.x[far.places] == pytest.approx(0.05 * far.x)


def test_a_shape_that_is_a_count_is_found():
    verdict = found(1, ((WAVES_OF_23, 0.05),), {"washboard": WAVES})
    assert verdict.effects == ["washboard"]
    assert verdict.parameters["washboard.count"]["value"] == pytest.approx(23.0, abs=0.2)


def test_shapes_lie_inside_the_bounds():
    for each in effects().values():
        for shape in shapes(each):
            for name, value in shape.items():
                low, high = next(
                    p.bounds for p in each.parameters if each.full_name(p.name) == name
                )
                assert low <= value <= high
        assert shapes(each)


def test_what_is_easily_confused_was_measured_both_ways():
    for effect in effects():
        for recorded, others in confusable(effect).items():
            assert list(others.values()) == sorted(others.values(), reverse=True)
            for other, cosine in others.items():
                assert 0.0 < cosine <= 1.0
                assert confusable(other)[recorded][effect] == pytest.approx(cosine, abs=2e-3)
    assert "capstan" in text("gear_load")
    assert text("nobody_knows").endswith("is not yet measured")
