"""Generic disturbances: what their series are, and when one stands against a name."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hannes.core.kernels.jit import plain
from hannes.identification.diagnosis.decision import decide
from hannes.identification.diagnosis.generic_disturbances import (
    DRAGGING,
    EASING,
    EFFECTS,
    GENERIC_NAMES,
    OPENING,
    TORQUE,
)
from hannes.identification.diagnosis.trials import Trial
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.catalogue import effects


def test_what_has_no_name_is_in_no_catalogue_and_fits_a_hand():
    assert list(GENERIC_NAMES) == [each.name for each in EFFECTS]
    assert not set(GENERIC_NAMES) & set(effects())
    assert not any(HandPlant().accepts(each) for each in EFFECTS)


def test_any_torque_is_series_of_the_angle_and_of_the_load():
    sizes = {each.name: 0.1 * k for k, each in enumerate(TORQUE.parameters, 1)}
    turn, load = np.pi * 3.0 / 10.0, 0.2
    free = sum(0.1 * k * np.cos(k * turn) for k in range(1, 6))
    loaded = sum(0.1 * (k + 5) * np.cos(k * turn) for k in range(1, 5))
    found_value = plain(TORQUE.terms[0].kernel)(3.0 * 19.0, 19.0, load, **sizes)
    assert found_value == pytest.approx(free + load * loaded, rel=1e-12)


def test_any_opening_is_a_series_of_the_way_that_a_joint_has_closed():
    absorbed = {each.name: 0.1 * k for k, each in enumerate(OPENING.parameters, 1)}
    assert list(absorbed) == ["legendre_2", "legendre_3", "legendre_4"]
    opening = plain(OPENING.terms[0].kernel)(0.9, 0.3, **absorbed)
    series = np.polynomial.legendre.legval(
        2.0 * (0.9 - 0.3) / 1.5 - 1.0, [0, 0, *absorbed.values()]
    )
    assert opening == pytest.approx(series, rel=1e-12)


def test_any_dragging_turns_with_the_way_a_joint_goes():
    drag = {each.name: 0.1 * k for k, each in enumerate(DRAGGING.parameters, 1)}
    assert list(drag) == ["drag_1", "drag_2", "drag_3"]
    kernel, series = plain(DRAGGING.terms[0].kernel), np.polynomial.legendre.legval
    against = series(2.0 * (0.9 - 0.3) / 1.5 - 1.0, [0, *drag.values()])
    found_value = [kernel(0.9, speed, 0.3, **drag) for speed in (-5.0, 0.0, 5.0)]
    assert found_value == pytest.approx([-against, 0.0, against], rel=1e-12)


def test_what_eases_is_lost_exponentially_and_never_more_than_the_pull():
    kernel, eased, step = plain(EASING.terms[0].kernel), 0.0, 1e-3
    for _ in range(2000):
        change, rate = kernel(30.0, eased, 0.5)
        eased += step * rate
    assert change == pytest.approx(-30.0 * (1.0 - np.exp(-0.5 * 2.0)), rel=1e-3)
    assert kernel(1.0, eased, 0.5) == (-1.0, 0.0)


def of_one_number(chi2):
    """A fit with a generic disturbance that no law beats by fewer numbers."""
    return SimpleNamespace(chi2=chi2, space=SimpleNamespace(of=lambda name: np.arange(1)))


def test_what_a_generic_disturbance_explains_as_well_has_no_name(investigated):
    best, masks = investigated.trials[0], ([0b011] * 2, [0b100] * 2)
    kinds, point = {}, of_one_number(best.point.chi2)
    for lost in (5.0, 0.5 * best.delta_chi2):
        rival = Trial(("any_torque",), point, best.delta_chi2 - lost)
        kinds[lost] = decide(replace(investigated, generic=rival), *masks)
    assert [each.kind for each in kinds.values()] == ["unknown", "named"]
    assert "something else may be there" in kinds[5.0].reason


def test_a_generic_disturbance_that_does_far_less_is_no_rival(investigated):
    masks, kinds = ([0b011] * 2, [0b100] * 2), []
    best = replace(investigated.trials[0], delta_chi2=SEARCH.name_limit + 1.0)
    for apart in (SEARCH.rival + 0.1, SEARCH.rival - 0.1):
        delta_chi2 = max(best.delta_chi2 - apart, SEARCH.faint)
        rival = Trial(("any_torque",), of_one_number(best.point.chi2), delta_chi2)
        found = replace(investigated, trials=[best], joint=None, generic=rival)
        kinds.append(decide(found, *masks).kind)
    assert kinds == ["named", "unknown"]
