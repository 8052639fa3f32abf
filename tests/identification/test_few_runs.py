"""Few runs, honestly: what the test of repeats can reach, and the spread of repeats beside it."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.calibration import repeatable_residual as module
from hannes.identification.calibration.identifiability import IDENTIFIED, NOT_IDENTIFIED, answers
from hannes.identification.calibration.repeatable_residual import repeatable_residual
from hannes.identification.calibration.tuning import CALIBRATION

BINS = 60
SHAPE = np.sin(np.linspace(0.0, 9.0, BINS))


@pytest.fixture
def judged(monkeypatch):
    """What is said of residuals: a list of conditions, each of rows (runs, bins)."""

    def judge(groups, seed=1):
        monkeypatch.setattr(module, "_groups", lambda found: groups)
        monkeypatch.setattr(module, "_by_channel", lambda found: {})
        return repeatable_residual(SimpleNamespace(plan=SimpleNamespace(seed=seed)))

    return judge


def rows(count, missing, seed, spread=1.0):
    """Runs that differ in one way by `spread`, with the same `missing` in all."""
    rng = np.random.default_rng(seed)
    way = np.cos(np.linspace(0.0, 7.0, BINS))
    apart = spread * rng.standard_normal((count, 1)) * way
    return missing * SHAPE + apart + 0.1 * rng.standard_normal((count, BINS))


@pytest.mark.parametrize("count", [2, 3, 4])
def test_so_few_runs_never_say_that_the_residual_does_not_repeat(judged, count):
    found = judged([rows(count, 1.0, 3)])
    assert found.smallest == 2.0 ** (1 - count) > CALIBRATION.repeat_p_value
    assert found.repeats is not False
    assert "oo few runs" in found.sentence or found.repeats


def test_conditions_add_to_what_signs_can_reach(judged):
    found = judged([rows(3, 1.0, k) for k in range(3)])
    assert found.smallest == pytest.approx(2.0**-6)


@pytest.mark.parametrize("conditions", [2, 3])
def test_a_model_that_lacks_ten_times_the_spread_is_wrong_by_two_runs_each(judged, conditions):
    said = [judged([rows(2, 10.0, 10 * k + c) for c in range(conditions)]) for k in range(20)]
    assert sum(each.repeats is True for each in said) >= 14
    assert all(each.repeats is not False for each in said)
    assert all(each.misleads for each in said)


def test_sound_residuals_are_not_called_wrong(judged):
    """Runs that differ in one way alone are the worst case; at a level of 1 % and of 5 %."""
    said = [
        judged([rows(int(2 + (k + c) % 3), 0.0, 100 * k + c) for c in range(1 + k % 3)])
        for k in range(150)
    ]
    assert np.mean([each.repeats is True for each in said]) <= 0.06


def test_beside_a_residual_that_misleads_nothing_is_identified(monkeypatch):
    from hannes.identification.calibration import identifiability

    class One(SimpleNamespace):
        identified = True

    made = []
    monkeypatch.setattr(identifiability, "_answer", lambda *a: One(label=IDENTIFIED))
    monkeypatch.setattr(
        identifiability, "replace", lambda each, **new: made.append(new) or One(**new)
    )
    found = SimpleNamespace(plan=SimpleNamespace(names=("motor.resistance",)))
    (answer,) = answers(found, None, None, "the model does not fit")
    assert answer.label == NOT_IDENTIFIED and made[0]["reason"] == "the model does not fit"
    (answer,) = answers(found, None, None)
    assert answer.label == IDENTIFIED
