"""What an estimate of the stiffness lacks is seen in its errors: grasps, or values of the hand."""

import numpy as np
import pytest

from benchmarks.gripping.known import Pressed, rows_of


def drawn(count, hidden):
    """Grasps whose traces show the stiffness plus `hidden` of a value of the hand."""
    rng = np.random.default_rng(3)
    stiffness, others = rng.uniform(-0.5, 0.5, count), rng.normal(size=(count, 2))
    traces = rng.normal(size=(count, 20))
    traces[:, 0] = 2.0 * (stiffness + hidden * others[:, 1])
    hands = others[:, 1:] + 0.3 * rng.normal(size=(count, 1))  # what a closure on nothing shows
    return Pressed(traces, stiffness, others, hands, np.array([True, False]))


def test_what_the_hands_values_would_gain_is_seen():
    rows = {row["given besides"]: row for row in rows_of(drawn(4000, 0.1))}
    assert rows["nothing"]["error"] > 0.08
    assert rows["the object's other values"]["error"] > 0.08
    assert rows["the hand"]["error"] < 0.01 and rows["both"]["error"] < 0.01
    assert 0.02 < rows["the hand's empty closure"]["error"] < 0.05
    assert rows["nothing"]["error"] == pytest.approx(rows["nothing"]["of fitted ones"], rel=0.1)


def test_where_grasps_are_few_those_that_were_fitted_are_nearer():
    few, *_ = rows_of(drawn(4000, 0.1).of_every(8))
    assert few["error"] > 1.5 * few["of fitted ones"]
