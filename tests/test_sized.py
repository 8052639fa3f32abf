"""How large what was named is, and how surely: finer bins, and the floor of a kinked valley."""

from types import SimpleNamespace

import numpy as np
import pytest
from sled import KNOWN, TURBULENCE, Sled, recordings

from hannes.diagnosis import profile as profiles
from hannes.diagnosis import sized as module
from hannes.diagnosis.fit import deviations
from hannes.diagnosis.groups import Group
from hannes.diagnosis.investigation import FINE, investigate
from hannes.diagnosis.profile import profile
from hannes.diagnosis.settings import Settings
from hannes.diagnosis.sized import FINER, sized
from hannes.errors import ComputationFailed

SIZE = 2.0  # N s^2/m^2
NAME = ["turbulence"]


@pytest.fixture(scope="module")
def named():
    """The fit with the effect that is hidden."""
    entries = [each for each in recordings(1, ((TURBULENCE, SIZE),)) if each.role != "show"]
    found = investigate(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    return found.trials[0].point


def of(point, name="turbulence"):
    """Place of an effect's size, its row among the active directions, and what a step is."""
    space = point.ground.model.space
    place = int(space.of(name)[0])
    return place, int(np.searchsorted(point.active, place)), space.directions[place].scale


def test_groups_have_so_many_times_as_many_bins(named):
    for group in named.ground.model.groups:
        narrow = Group(Sled(), group.entries, FINER)
        assert narrow.width == pytest.approx(group.width / FINER)
        assert narrow.bins == pytest.approx(FINER * group.bins, abs=1)


def test_effects_are_part_of_a_machine_that_holds_them(named):
    model = named.ground.model
    held, rows = model.held(model.groups), named.x[np.newaxis]
    for group in model.groups:
        without, with_effect = (model.vectors(group, rows, each) for each in (False, True))
        assert np.array_equal(held.vectors(group, rows, False), with_effect)
        assert np.abs(with_effect - without).max() > 1e-3
        moved = rows + 0.1 * (np.arange(rows.size) == 0)
        changes = held.changes(group, named.x, moved, False)
        assert np.array_equal(changes, model.changes(group, named.x, moved, True))


def test_what_was_named_is_known_better_in_finer_bins(named):
    found = sized(named, NAME, FINE, 0)
    place, row, scale = of(named)
    coarse, narrow = deviations(named)[row], found.deviations[place]
    assert narrow < 0.9 * coarse
    assert abs(found.point.x[place] * scale - SIZE) < 3.0 * narrow * scale
    others = set(named.active.tolist()) - {place}
    assert set(found.deviations) == {place, *others}
    assert found.point.active.tolist() == sorted(others)  # that one is held where it is least


def test_where_finer_bins_cannot_be_simulated_the_fit_stays(named, monkeypatch):
    def broken(*_):
        raise ComputationFailed("not here")

    monkeypatch.setattr(module, "begun", broken)
    found = sized(named, NAME, FINE, 0)
    assert found.point is named
    assert list(found.deviations.values()) == deviations(named).tolist()


def test_a_smooth_valley_has_the_floor_and_width_that_slopes_tell(named):
    place, row, _ = of(named)
    least, deviation = profile(named, place, deviations(named)[row])
    assert abs(least - named.x[place]) < 0.3 * deviation
    assert deviation == pytest.approx(deviations(named)[row], rel=0.15)


def valley(monkeypatch, misfit, at, deviation=0.1, low=-10.0):
    """The profile of a made-up misfit over one direction, walked from a place."""

    def held(point, places, values):
        there = SimpleNamespace(x=np.array(values), misfit=misfit(values[0]), ground=ground)
        return there if np.isfinite(there.misfit) else None

    space = SimpleNamespace(low=np.array([low]), high=np.array([10.0]))
    ground = SimpleNamespace(model=SimpleNamespace(space=space))
    monkeypatch.setattr(profiles, "held_at", held)
    point = SimpleNamespace(x=np.array([at]), misfit=misfit(at), ground=ground)
    return profile(point, 0, deviation)


def test_of_a_kinked_valley_the_floor_is_found_from_a_hollow_on_its_side(monkeypatch):
    """As wide as 0.5, with hollows 0.3 apart in which slopes tell a width of 0.1."""
    least, deviation = valley(
        monkeypatch, lambda x: ((x - 1.0) / 0.5) ** 2 + 2.0 * np.sin(10.0 * x) ** 2, 1.57
    )
    assert least == pytest.approx(1.0, abs=0.25)
    assert deviation == pytest.approx(0.5, rel=0.4)


def test_another_valley_does_not_count(monkeypatch):
    def two(x):
        return (x / 0.1) ** 2 if x < 0.2 else 80.0 + x

    least, deviation = valley(monkeypatch, two, 0.0)
    assert least == pytest.approx(0.0, abs=1e-9)
    assert deviation == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize(
    ("misfit", "low"),
    [(lambda x: -abs(x), -10.0), (lambda x: 0.0 if x == 0.0 else np.nan, -10.0)],
    ids=["no floor", "breaks down beside it"],
)
def test_where_there_is_no_valley_slopes_tell(monkeypatch, misfit, low):
    assert valley(monkeypatch, misfit, 0.0, low=low) == (0.0, 0.1)


def test_the_floor_is_inside_the_range(monkeypatch):
    least, _ = valley(monkeypatch, lambda x: ((x + 0.2) / 0.1) ** 2, 0.0, low=0.0)
    assert least == 0.0
