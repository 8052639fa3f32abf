"""Of an effect's sizes only those stay that the recordings ask for."""

from types import SimpleNamespace

import pytest

from hannes.diagnosis import parsimony
from hannes.diagnosis.investigation import PRICE
from hannes.diagnosis.parsimony import APART, spared
from hannes.dynamics.wire_compliance import EFFECT

NAME = EFFECT.name


def fit(monkeypatch, without, effect=EFFECT):
    """A made-up fit of two sizes, at places 3 and 4; without: misfit by the places held at off."""
    names = [effect.full_name(each.name) for each in effect.amplitudes]
    space = SimpleNamespace(effects={effect.name: effect}, place=lambda n: 3 + names.index(n))
    ground = SimpleNamespace(model=SimpleNamespace(space=space))

    def held(point, places, values):
        assert not values.any()  # off
        off = (*point.off, *places.tolist())
        misfit = without[off]
        return None if misfit is None else SimpleNamespace(misfit=misfit, off=off, ground=ground)

    monkeypatch.setattr(parsimony, "held_at", held)
    return SimpleNamespace(misfit=100.0, off=(), ground=ground)


def test_what_lowers_the_misfit_by_too_little_stays_at_off(monkeypatch):
    point = fit(monkeypatch, {(3,): 150.0, (4,): 100.0 + 0.9 * PRICE})
    assert spared(point, [NAME], 1.0).off == (4,)


def test_what_is_asked_for_stays(monkeypatch):
    point = fit(monkeypatch, {(3,): 150.0, (4,): 100.0 + 1.1 * PRICE})
    assert spared(point, [NAME], 1.0) is point
    assert spared(point, [NAME], 1.3).off == (4,)  # in the noise that is there it is not


def test_where_either_could_go_both_stay(monkeypatch):
    point = fit(monkeypatch, {(3,): 101.0 + 0.9 * APART, (4,): 101.0})
    assert spared(point, [NAME], 1.0) is point


@pytest.mark.parametrize("lost", [3, 4])
def test_a_size_without_which_nothing_can_be_simulated_stays(monkeypatch, lost):
    point = fit(monkeypatch, {(3,): 101.0, (4,): 101.0} | {(lost,): None})
    assert spared(point, [NAME], 1.0).off == (7 - lost,)


def test_the_last_size_stays(monkeypatch):
    point = fit(monkeypatch, {(3,): 150.0, (4,): 100.0, (4, 3): 100.0})
    assert spared(point, [NAME], 1.0).off == (4,)
