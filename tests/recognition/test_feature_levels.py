"""Features rounded to few levels: trees grown on them send unrounded features the same way."""

import numpy as np
import pytest
from sklearn.tree import DecisionTreeRegressor

from hannes.recognition import feature_levels
from hannes.recognition.feature_levels import LEVELS, rounded


@pytest.fixture(scope="module")
def features():
    """Features of 40 grasps: smooth, rounded already, mostly zero; NaN in windows not used."""
    rng = np.random.default_rng(4)
    made = rng.standard_normal((40, 50, 3)).astype(np.float32)
    made[..., 1] = np.round(made[..., 1], 1)
    made[..., 2] *= made[..., 2] > 1.0
    used = rng.random((40, 50)) < 0.8
    made[~used] = np.nan
    return made, used


def test_levels_are_few_and_near_and_other_windows_stay(features):
    made, used = features
    found = rounded(made, used)
    assert np.isnan(found[~used]).all() and found.dtype == np.float32
    for k in range(3):
        before, after = made[used][:, k], found[used][:, k]
        assert len(np.unique(after)) <= LEVELS and set(after) <= set(before)
        order = np.argsort(before, kind="stable")
        assert (np.diff(after[order]) >= 0.0).all()
        within = np.abs(before) < 2.0
        assert np.abs(after - before)[within].mean() < 0.05
    assert (found[used][made[used][:, 2] == 0.0][:, 2] == 0.0).all()


def test_a_tree_grown_on_levels_sends_unrounded_features_the_same_way(features):
    made, used = features
    rows, levels = made[used], rounded(made, used)[used]
    target = np.sin(rows[:, 0]) + rows[:, 1] * rows[:, 2]
    tree = DecisionTreeRegressor(min_samples_leaf=2, random_state=1).fit(levels, target)
    assert np.array_equal(tree.apply(rows), tree.apply(levels))


def test_levels_are_of_some_windows_where_there_are_many(features, monkeypatch):
    made, used = features
    monkeypatch.setattr(feature_levels, "MOST_SEEN", 200)
    found = rounded(made, used)[used][:, 0]
    assert np.abs(found - made[used][:, 0]).mean() < 0.1
