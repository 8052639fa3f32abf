"""Trees as plain arrays equal scikit-learn's; out-of-bag predictions use unseen grasps alone."""

import numpy as np
import pytest
from sklearn.ensemble import RandomForestRegressor
from sklearn.tree import DecisionTreeClassifier

from hannes.recognition.bagging import Rows, bagged
from hannes.recognition.forest import QUANTILES, of_sklearn


def test_compiled_trees_equal_those_of_scikit_learn():
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((3000, 6)).astype(np.float32)
    line = RandomForestRegressor(21, random_state=1).fit(rows[:2000], rows[:2000, 3])
    forest = of_sklearn(line.estimators_).check(6)
    assert np.allclose(forest(rows), line.predict(rows), rtol=0.0, atol=1e-12)
    by_tree = np.array([each.predict(rows) for each in line.estimators_])
    quantiles = np.quantile(by_tree, QUANTILES, axis=0).T
    assert np.allclose(forest.quantiles(rows), quantiles, rtol=0.0, atol=1e-12)


def test_trees_of_classes_split_as_scikit_learns_classifier_does():
    rng = np.random.default_rng(0)
    features = rng.standard_normal((60, 50, 6)).astype(np.float32)
    classes = (features[:, 0, 0] > 0.0).astype(int)
    rows, owner = features.reshape(-1, 6), np.repeat(np.arange(60), 50)
    known = Rows(rows, classes[owner].astype(float), np.ones(3000), owner)
    bag = bagged(known, 60, 8, 1.0, 3, 1, max_depth=4)
    for tree, seen in zip(bag.trees, bag.seen, strict=True):
        assert seen.sum() == round(0.632 * 60)
        again = DecisionTreeClassifier(max_depth=4, random_state=tree.random_state)
        again.fit(features[seen].reshape(-1, 6), np.repeat(classes[seen], 50))
        assert np.allclose(tree.predict(rows), again.predict_proba(rows)[:, 1], atol=1e-9)


def test_out_of_bag_predictions_are_by_trees_that_have_not_seen_the_grasp():
    rng = np.random.default_rng(0)
    features = rng.standard_normal((40, 3)).astype(np.float32)
    rows = Rows(features, rng.standard_normal(40), np.ones(40), np.repeat(np.arange(20), 2))
    bag = bagged(rows, 20, 30, 1.0, 1, 1)
    prediction, owner = bag.mean_unseen(features, rows.owner), rows.owner
    middle = bag.quantiles_unseen(features, owner)
    for k in range(40):
        others = [t for t, seen in zip(bag.trees, bag.seen, strict=True) if not seen[owner[k]]]
        values = [t.predict(features[k : k + 1])[0] for t in others]
        assert 0 < len(values) < 30 and prediction[k] == pytest.approx(np.mean(values))
        assert middle[k] == pytest.approx(np.quantile(values, QUANTILES))
    seen = np.mean([t.predict(features) for t in bag.trees], axis=0)
    miss, honest = (np.abs(each - rows.target).mean() for each in (seen, prediction))
    assert miss < 0.5 * honest  # trees grown to single samples know what they have seen
