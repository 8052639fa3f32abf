"""Fits of generic disturbances race: which go on is decided by what they have reached."""

from dataclasses import dataclass

from hannes.identification.diagnosis.shape import likeliest
from hannes.identification.diagnosis.shape.likeliest import Described


@dataclass(frozen=True)
class Reached:
    """A fit of whose way to its least a tenth is left with each call."""

    chi2: float
    least: float
    steps: int = 0


def walked(point, _steps):
    return Reached(point.least + 0.1 * (point.chi2 - point.least), point.least, point.steps + 1)


def raced(monkeypatch, *least):
    monkeypatch.setattr(likeliest, "fitted", walked)
    starts = [Described(k, None, None, Reached(100.0, each), 0.0) for k, each in enumerate(least)]
    return list(likeliest._raced(starts, lambda text: None))


def test_the_better_half_goes_on_until_one_is_left(monkeypatch):
    fits = raced(monkeypatch, 60.0, 5.0, 80.0, 90.0, 30.0)
    assert [each.description for each in fits] == [0, 1, 2, 3, 4, 1, 4, 1]
    assert [each.point.steps for each in fits][-3:] == [2, 2, 3]


def test_what_a_fit_lowers_is_counted_from_its_start(monkeypatch):
    first, last = raced(monkeypatch, 50.0, 20.0)[0], raced(monkeypatch, 50.0, 20.0)[-1]
    assert first.reduction == 45.0 and last.reduction == 100.0 - last.point.chi2


def test_nothing_promising_is_no_race(monkeypatch):
    assert raced(monkeypatch) == []
