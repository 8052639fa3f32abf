"""The peak force of a released grasp: hysteresis features and Gaussian processes."""

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RationalQuadratic
from threadpoolctl import threadpool_limits

from hannes.recognition import gaussian_process, hysteresis_features
from hannes.recognition.hysteresis_features import grasp_features
from hannes.recognition.training_set import all_grasp_features
from hannes.recognition.windowing import Windowing


def grasp_of_a_spring(closing, opening, lead=0.1):
    """A shaft that goes to 9 rad and back, with 0.2 A of friction and 0.5 A/rad from 7 rad on."""
    time = np.arange(int(1000 * (lead + 9.0 / closing + 9.0 / opening))) / 1000.0 - lead
    turn = 9.0 / closing
    position = np.interp(time, [0.0, turn, turn + 9.0 / opening], [0.0, 9.0, 0.0])
    current = 0.5 * np.maximum(position - 7.0, 0.0) + np.where(time < turn, 0.2, -0.2)
    return np.stack([current, position, position], axis=1)


@pytest.mark.parametrize(("closing", "opening"), [(3.0, 3.0), (15.0, 25.0)])
def test_hysteresis_features_are_of_the_same_angles_both_ways(closing, opening):
    samples, windowing = grasp_of_a_spring(closing, opening), Windowing()
    windows = windowing.features(samples[np.newaxis])
    (found,) = all_grasp_features(samples[np.newaxis], windows, windowing)
    prediction = dict(zip(hysteresis_features.WHOLE, found, strict=True))
    step = 0.5 * opening * 1e-3  # A, of one sample
    assert prediction["farthest"] == pytest.approx(9.0, abs=2.0 * step)
    assert prediction["squeeze"] == pytest.approx(2.0, abs=0.3)
    assert prediction["farthest_since"] == pytest.approx(prediction["squeeze"] / closing, abs=0.03)
    for short in hysteresis_features.SHORT:
        if short < 0.005 * opening:  # the mean over 10 ms reaches across the turn
            continue
        spring, name = 0.5 * (2.0 - short), f"{1e3 * short:.0f}_mrad"
        going = prediction[f"closing_{name}"] + prediction["free_current"]
        assert going == pytest.approx(spring + 0.2, abs=2.0 * step)
        assert prediction[f"opening_{name}"] == pytest.approx(spring - 0.2, abs=2.0 * step)
    assert np.isnan(grasp_features(samples, windows[0], -1, windowing)).all()  # no contact
    end = int(100 + 9000 / closing + 400 / opening)  # back by 0.4 rad, and still held
    part = windowing.features(samples[np.newaxis, :end])
    assert np.isnan(all_grasp_features(samples[np.newaxis, :end], part, windowing)).all()


def test_the_mean_is_that_of_scikit_learns_gaussian_processes():
    rng = np.random.default_rng(3)
    rows = rng.standard_normal((120, 4)) * [1.0, 10.0, 0.1, 1e-7] + [0.0, 0.0, 0.0, 5.0]
    target = np.sin(rows[:, 0]) + 0.05 * rows[:, 1]
    made, unseen = gaussian_process.train_process(rows, target, seed=1)
    points = gaussian_process.standard(rows, made.centre, made.scale)
    order = np.random.default_rng(1).permutation(120)
    prediction = np.zeros(120)
    for part in (order[:40], order[40:80], order[80:]):
        others = order[~np.isin(order, part)]
        process = GaussianProcessRegressor(
            RationalQuadratic(made.length[0], alpha=1.0),
            alpha=gaussian_process.NOISE,
            optimizer=None,
            normalize_y=True,
        ).fit(points[others], target[others])
        assert unseen[part] == pytest.approx(process.predict(points[part]), abs=1e-6)
        prediction += process.predict(points) / 3.0
    inside = (prediction > target.min()) & (prediction < target.max())
    assert made(rows)[inside] == pytest.approx(prediction[inside], abs=1e-5)
    assert np.abs(unseen - target).mean() < 0.15
    rounded = rows + np.array([0.0, 0.0, 0.0, 1e-6])  # ten times its spread: rounding is no feature
    assert made(rounded) == pytest.approx(made(rows), abs=1e-6)
    far = made(np.array([[50.0, 1e4, -3.0, 1.0]]))
    assert target.min() <= far[0] <= target.max()


def test_processes_train_on_some_rows_and_predict_the_others(monkeypatch):
    monkeypatch.setattr(gaussian_process, "MOST", 60)
    rows = np.random.default_rng(3).standard_normal((90, 2))
    made, unseen = gaussian_process.train_process(rows, rows[:, 0], seed=1)
    assert made.points.shape == (60, 2) and np.isfinite(unseen).all()
    rest = np.random.default_rng(1).permutation(90)[60:]
    assert unseen[rest] == pytest.approx(made(rows[rest]))


def test_processes_are_the_same_for_any_number_of_threads():
    rng = np.random.default_rng(3)
    rows = rng.standard_normal((1500, 20))
    target = rows @ rng.standard_normal(20)
    made = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            made.append(gaussian_process.train_process(rows, target, seed=1)[0])
    for name in gaussian_process.FIELDS:
        assert np.array_equal(getattr(made[0], name), getattr(made[1], name))


def test_equal_rows_predict_their_mean():
    made, unseen = gaussian_process.train_process(np.ones((60, 3)), np.arange(60.0), seed=1)
    assert made(np.ones((1, 3)))[0] == pytest.approx(29.5, abs=0.5)
    assert np.isfinite(unseen).all()
