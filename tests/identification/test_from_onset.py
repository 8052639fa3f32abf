"""A fault that acts from some size on is looked at a step apart from there, any other is not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis import from_onset
from hannes.identification.diagnosis.from_onset import looked_at_from_onset
from hannes.identification.diagnosis.tuning import ONSET

WITHOUT, LOW, HIGH = 8000.0, -40.0, 25.0
FURTHER = np.array([[-14.0, 0.0], [-29.0, 0.0]])  # sizes that were looked at before


@pytest.fixture
def looked(monkeypatch):
    """What is looked at of a fault whose left_by by size is given."""
    space = SimpleNamespace(
        effects={"stop": None}, low=np.array([LOW, -1.0]), high=np.array([HIGH, 1.0]), size=2,
        place=int,
    )  # fmt: skip
    nominal, asked = SimpleNamespace(space=space, x=np.zeros(2)), []
    monkeypatch.setattr(from_onset, "amplitude_names", lambda effect: ["0", "1"])

    def call(left_by):
        def left_at(_, name, rows):
            asked.append(len(rows))
            return np.array([left_by(row[0]) for row in rows])

        monkeypatch.setattr(from_onset, "left_at", left_at)
        before = FURTHER, left_at(nominal, "stop", FURTHER)
        return *looked_at_from_onset(nominal, "stop", before), sum(asked)

    return call


@pytest.mark.parametrize("right", [-25.3, -27.4, -36.9])
def test_a_valley_of_one_step_beyond_the_onset_is_seen(looked, right):
    def left_by(size):
        """A thumb's stop: nothing down to -24, then 8,000 more but for one narrow valley."""
        return WITHOUT if size > -24.2 else 2.0 * WITHOUT * min(1.0, abs(size - right))

    rows, left, made = looked(left_by)
    assert left.min() <= WITHOUT and abs(rows[np.argmin(left), 0] - right) < 0.5
    assert rows[2:, 0].max() > -25.3 and rows[2:, 0].min() >= LOW
    end, *steps = np.diff(np.sort(rows[2:, 0]))
    assert steps == pytest.approx([1.0] * len(steps)) and 0.0 < end <= 1.0
    assert rows[2:, 0].min() == LOW
    assert made < 60


@pytest.mark.parametrize(
    "left_by",
    [lambda size: WITHOUT - 3.0 * abs(size), lambda size: WITHOUT + 0.5 * ONSET.acts * (size < 0)],
    ids=["acts from the first step", "never acts"],
)
def test_a_fault_without_an_onset_is_left_as_it_was(looked, left_by):
    rows, left, made = looked(left_by)
    assert rows.tolist() == FURTHER.tolist() and left.size == 2
    assert made < 10
