"""The paper's figures of merit on curves drawn by hand, whose figures are known beforehand."""

import numpy as np
import pytest

from hannes.simulation.grasp_metrics import (
    DEFINITIONS,
    GraspMetrics,
    closing_time,
    grasp_metrics,
    relative_error,
    smoothed,
    void_current,
)

T = np.arange(1201) / 1000.0
CONTACT, RELEASE, BACK = 0.28, 0.85, 1.0  # s
# Current [A] of straight lines: closing, squeezing, a flat peak, letting go, opening the other way.
CURRENT = np.interp(
    T,
    [0.0, 0.30, 0.60, 0.63, 0.83, 0.84, 1.2],
    [0.3, 0.30, 2.50, 2.50, 0.10, -0.2, -0.2],
)
FORCE = np.interp(
    T, [CONTACT - 1e-9, CONTACT, 0.61, RELEASE, RELEASE + 1e-9], [0, 1.5, 180, 1.2, 0]
)
POSITION = np.interp(T, [0.0, 0.6, 0.7, BACK + 0.01, 1.2], [0.0, 8.0, 8.0, 0.7, 0.0])


def grasp(current=CURRENT, force=FORCE, position=POSITION, time=T):
    """Measure a grasp."""
    return grasp_metrics(time, current, force, position)


def test_every_figure_of_the_drawn_grasp():
    found = grasp()
    assert found.contact == CONTACT and found.release == RELEASE
    assert found.I_avgc == pytest.approx(0.3, rel=1e-12)
    assert found.I_avgo == pytest.approx(0.2, rel=1e-12)  # by magnitude
    assert found.I_max == pytest.approx(2.5, rel=1e-12)
    assert found.I_sc == pytest.approx(2.2 / 0.3, rel=1e-9)
    assert found.I_so == pytest.approx(-2.4 / 0.2, rel=1e-9)
    assert found.F_max == pytest.approx(180.0, rel=1e-3)


def test_contact_is_the_first_force_above_one_newton():
    light = np.where((T > 0.2) & (T < CONTACT), 0.99, FORCE)
    assert grasp(force=light).contact == CONTACT
    assert grasp(force=np.where(T == 0.2, 1.01, FORCE)).contact == 0.2


def test_the_mean_of_closing_starts_after_the_motor_has():
    start = np.where(T < 0.013, 5.0, CURRENT)  # its last smoothed trace ends at 0.02 s
    assert grasp(current=start).I_avgc == pytest.approx(0.3, rel=1e-12)
    late = np.where((T >= 0.02) & (T < 0.04), 5.0, CURRENT)
    assert grasp(current=late).I_avgc > 0.5


def test_the_slopes_are_those_of_the_last_rise_and_the_first_fall():
    early = CURRENT + np.where((T > 0.1) & (T < 0.14), 1.9, 0.0)
    found, plain = grasp(current=early), grasp()
    assert found.I_avgc > plain.I_avgc
    assert found.I_sc == pytest.approx(plain.I_sc, rel=1e-9)
    again = CURRENT + np.where((T > 0.9) & (T < 0.93), -2.0, 0.0)  # rises again while opening
    assert grasp(current=again).I_so == pytest.approx(plain.I_so, rel=1e-9)


def test_the_mean_of_opening_ends_where_the_motor_is_back():
    after = np.where(T > BACK + 0.02, -3.0, CURRENT)
    assert grasp(current=after).I_avgo == pytest.approx(0.2, rel=1e-12)
    assert np.isnan(grasp(position=np.maximum(POSITION, 1.0)).I_avgo)


def test_what_has_no_sense_is_not_a_number():
    untouched = grasp(force=np.zeros_like(T))
    assert all(np.isnan(getattr(untouched, name)) for name in GraspMetrics.__annotations__)
    at_once = grasp(force=np.full_like(T, 2.0))
    assert np.isnan(at_once.I_avgc) and np.isnan(at_once.I_sc)
    assert np.isnan(at_once.release)  # held to the end


def test_smoothing_is_a_centred_mean_of_eleven_milliseconds():
    impulse = np.zeros(101)
    impulse[50] = -11.0
    assert np.flatnonzero(smoothed(impulse)).tolist() == list(range(45, 56))
    assert smoothed(impulse).max() == pytest.approx(1.0)
    assert np.flatnonzero(smoothed(impulse, 5000.0)).size == 55  # samples, whatever the rate
    assert np.allclose(smoothed(np.full(30, 0.4)), 0.4)  # the ends are no exception


def test_the_figures_do_not_depend_on_the_sampling():
    t = np.arange(6001) / 5000.0
    finer = grasp(*(np.interp(t, T, each) for each in (CURRENT, FORCE, POSITION)), time=t)
    for name in ("I_avgc", "I_max", "I_sc", "I_so", "F_max"):
        assert getattr(finer, name) == pytest.approx(getattr(grasp(), name), rel=2e-3)


def test_the_void_current_is_the_mean_of_its_window_alone():
    current = np.where(T < 0.14, 3.0, np.where(T < 0.31, -0.25, 3.0))
    assert void_current(T, current) == pytest.approx(0.25, rel=1e-12)


def test_the_closing_time_is_that_of_nine_tenths():
    assert closing_time(T, np.minimum(10.0 * T, 8.0)) == pytest.approx(0.72, abs=1e-12)
    assert np.isnan(closing_time(T, np.ones_like(T)))


def test_equation_4_keeps_its_sign():
    assert relative_error(2.477, 2.555) == pytest.approx(-3.149, abs=1e-3)  # Table II, I_max
    assert relative_error(194.8, 174.9) == pytest.approx(10.216, abs=1e-3)  # section III.C


def test_every_figure_has_its_definition():
    assert set(GraspMetrics.__annotations__) - {"release"} <= set(DEFINITIONS)
