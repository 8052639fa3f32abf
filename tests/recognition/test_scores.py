"""How predictions are scored: decisions, intervals, scores. No model is needed for it."""

import numpy as np
import pytest

from hannes.recognition.calibration import _band, _widened, least_sure
from hannes.recognition.evaluate import delay, f1
from hannes.recognition.interval_scores import judged
from hannes.recognition.model import FADE, NO_CONTACT, Band, Estimate, decided, running


def test_an_interval_is_wider_by_half_the_distance_of_the_values_learnt():
    none = np.zeros(2)
    band = _widened(Band(np.arange(2.0), none, none), np.array([1.0, np.e, np.e, np.e**4]))
    assert np.allclose(band.high, 1.0) and np.allclose(band.low, -1.0)  # of 1, 3: 2 on average
    assert np.allclose(_widened(band, np.full(5, 800.0)).high, band.high)


def test_an_interval_is_wider_where_trees_lie_further_apart():
    rng = np.random.default_rng(0)
    apart, true = rng.uniform(0.1, 1.0, 4000), np.full(4000, 20.0)
    prediction = true * np.exp(-0.3 * apart * rng.standard_normal(4000))
    band = _band(np.stack([prediction, apart], axis=1), true)
    for x in (0.3, 0.8):
        low, high = band(20.0, x)
        assert np.log(high / low) == pytest.approx(2.0 * 1.96 * 0.3 * x, rel=0.1)


def test_decisions_at_the_border_are_not_made_up():
    assert list(decided(np.array([0.1, 0.5, 0.54, 0.55, 0.9]), 0.55)) == [0, 2, 2, 1, 1]
    assert list(decided(np.array([0.49, 0.5]), 0.5)) == [0, 1]


def test_the_running_decision_fades_towards_what_was_last_seen():
    rigid = np.array([[0.9] * 5 + [0.2] * 40])
    prediction = running(rigid, rigid > 0.0, FADE / 3.0)[0]
    assert (np.diff(prediction[:5]) > 0.0).all() and 0.5 < prediction[0] < prediction[4] < 0.9
    assert prediction[5] > 0.5 > prediction[9] and prediction[-1] == pytest.approx(0.2, abs=1e-6)
    odds = np.log(prediction / (1.0 - prediction))
    assert odds[0] == pytest.approx(np.log(9.0) / 3.0)
    assert running(np.array([0.7]), np.array([True]), 1.0) == pytest.approx(0.7)
    no_contact = running(np.array([0.9, 0.9]), np.zeros(2, bool), 1.0)
    assert np.log(no_contact / (1.0 - no_contact)) == pytest.approx(NO_CONTACT)


def test_a_decision_counts_from_where_it_stays_right():
    times = np.arange(10) / 10.0

    def late(right, contact=0.2, release=0.8):
        return delay(times, np.array([c == "+" for c in right]), contact, release)

    assert late("--++++++++") == pytest.approx(0.0)  # what comes before contact does not count
    assert late("++-+-++++-") == pytest.approx(0.3)
    assert late("+++++++-++") == pytest.approx(0.6)
    assert late("++++++++-+") == late("++++++++++", 0.52, 0.55) == float("inf")


def test_a_class_is_named_from_where_it_beats_chance():
    rng = np.random.default_rng(0)
    true = np.repeat(rng.uniform(0.0, 1.0, 400), 10)
    classes = (rng.random(4000) < true).astype(float)
    owner = np.repeat(np.arange(400), 10)
    good = least_sure(true, classes, owner)
    assert 0.5 <= good <= 0.53
    coin = np.repeat(np.arange(400) % 2, 10).astype(float)
    assert least_sure(rng.random(4000), coin, owner) > good + 0.01


def test_the_papers_formula_for_an_object_of_one_class():
    right, wrong = 67, 33
    pr, re_ = right / (right + wrong), right / (right + 0)
    assert f1(right / (right + wrong)) == pytest.approx(2.0 * pr * re_ / (pr + re_))


def test_a_grasp_without_an_estimate_counts_as_missed():
    sure, off = Estimate(10.0, 9.0, 12.0), Estimate(11.0, 10.5, 12.0)
    prediction = judged([(10.0, sure), (10.0, off), (10.0, None)])
    assert prediction["grasps"] == 3 and prediction["answered"] == 2
    assert prediction["median_error_percent"] == pytest.approx(10.0)  # of 0, 10 and anything
    assert prediction["interval_holds"] == pytest.approx(1.0 / 3.0)
    assert prediction["errors_percent"] == [0.0, 10.0, None]
    assert judged([(10.0, sure), (10.0, None), (10.0, None)])["median_error_percent"] is None
    assert judged([(10.0, None)]) == {"grasps": 1, "answered": 0}
