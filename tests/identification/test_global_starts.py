"""Global starts, run-to-run variability both ways, and noise that was assumed too large."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from sled import KNOWN, TURBULENCE, Sled, effect, recordings

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter
from hannes.identification.diagnosis import deepest_minimum as minimum
from hannes.identification.diagnosis import global_starts, sizes_looked_at
from hannes.identification.diagnosis.deepest_minimum import _resized, deepest_minimum
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.gauss_newton import fitted
from hannes.identification.diagnosis.global_starts import (
    _signatures,
    global_fits,
    size_dependent,
)
from hannes.identification.diagnosis.multistart import started_at
from hannes.identification.diagnosis.noise_covariance import run_to_run_rows
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.score_test import stepped
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.simulation.catalogue import effects

ELSEWHERE = 0.07  # m
RUNS_DIFFER = 0.01  # N s/m, of drag: the 0.5 % assumed below, of 2


@kernel
def waves_elsewhere(size, position):
    """What waves of a rail do more where they are elsewhere [N]."""
    there = position - size
    waves = np.sin(60.0 * there) * np.exp(-((there / 0.15) ** 2))
    return 3.0 * (waves - np.sin(60.0 * position) * np.exp(-((position / 0.15) ** 2)))


SHIFTED = replace(
    effect("shifted", waves_elsewhere, 0.2, "m"),
    parameters=(Parameter("size", 0.0, "m", (-0.2, 0.2), "how far", off=0.0),),
)


@pytest.fixture(scope="module")
def shifted():
    """What an investigation finds of waves that are elsewhere."""
    entries = [e for e in recordings(3, ((SHIFTED, ELSEWHERE),)) if e.role != "show"]
    return search_effects(Sled(), entries, [*KNOWN.values(), SHIFTED], Settings(0.02, 0.005), 0)


def size(point):
    """How far elsewhere a fit has the waves [m]."""
    space = point.space
    own = space.of("shifted")[0]
    return point.x[own] * space.parameters[own].scale


def test_a_size_dependent_signature_is_found_by_global_starts(shifted, monkeypatch):
    monkeypatch.setattr(global_starts, "SEARCH", replace(SEARCH, lost_baseline=np.inf))
    nominal, baseline, asked = shifted.nominal, shifted.baseline, []
    assert size_dependent(nominal, ["shifted", "turbulence"]) == ["shifted"]
    fits = global_fits(nominal, baseline, ["turbulence", "shifted"], asked.append)
    assert asked == ["shifted, global starts"]
    assert size(fits["shifted"]) == pytest.approx(ELSEWHERE, rel=0.01)
    assert shifted.trials[0].effects == ("shifted",)
    assert size(shifted.trials[0].point) == pytest.approx(ELSEWHERE, rel=0.01)


def test_a_baseline_that_followed_an_effect_does_not_keep_it_from_starting_globally(monkeypatch):
    """What linear guesses at the machine as given leave is far above what a fit does."""
    tried = []
    monkeypatch.setattr(
        global_starts, "fits_from_nominal", lambda *given: tried.extend(given[2]) or {}
    )
    baseline = SimpleNamespace(chi2=560.0, residual=np.zeros(690))
    least = {"far": 2300.0, "near": 2500.0, "hopeless": 6000.0}
    global_starts._while_near(None, baseline, least, 6400.0, lambda text: None)
    assert tried == ["far", "near"]
    tried.clear()
    found = {"far": SimpleNamespace(chi2=520.0)}
    monkeypatch.setattr(
        global_starts, "fits_from_nominal",
        lambda *given: tried.extend(given[2]) or {k: found[k] for k in given[2] if k in found},
    )  # fmt: skip
    global_starts._while_near(None, baseline, least, 6400.0, lambda text: None)
    assert tried == ["far", "near"]


def test_where_the_baseline_leaves_far_too_much_likely_effects_start_globally(shifted, monkeypatch):
    """As slack of 4.4 mm, which every slope leads away from."""
    nominal, baseline = shifted.nominal, shifted.baseline
    effects = [*KNOWN, "shifted"]
    least = global_starts._least(nominal, effects, [], nominal.chi2)
    assert min(least, key=least.__getitem__) == "shifted"
    monkeypatch.setattr(global_starts, "size_dependent", lambda *_: [])
    per_bin = baseline.chi2 / baseline.residual.size
    one = replace(SEARCH, likely_effects=1)
    monkeypatch.setattr(global_starts, "SEARCH", replace(one, lost_baseline=0.9 * per_bin))
    fits = global_fits(nominal, baseline, effects, lambda text: None)
    assert list(fits) == ["shifted"]
    assert size(fits["shifted"]) == pytest.approx(ELSEWHERE, rel=0.01)
    monkeypatch.setattr(global_starts, "SEARCH", replace(one, lost_baseline=1.1 * per_bin))
    assert global_fits(nominal, baseline, effects, lambda text: None) == {}


def test_a_local_minimum_is_left_for_a_deeper_one_about_it(shifted):
    nominal = shifted.nominal
    own = nominal.space.of("shifted")
    scale = nominal.space.parameters[own[0]].scale
    local = fitted(started_at(nominal, own, np.array([0.1 / scale])), 5)
    assert size(local) > 1.2 * ELSEWHERE
    assert size(deepest_minimum(nominal, local, "shifted")) == pytest.approx(ELSEWHERE, rel=0.01)
    assert deepest_minimum(nominal, local, "turbulence") is local


@pytest.mark.parametrize(("share", "last"), [(0.0, False), (1e6, True)])
def test_a_minimum_deeper_by_little_of_what_is_left_is_the_last(shifted, monkeypatch, share, last):
    nominal, rounds = shifted.nominal, []
    own = nominal.space.of("shifted")
    scale = nominal.space.parameters[own[0]].scale
    local = fitted(started_at(nominal, own, np.array([0.1 / scale])), 5)
    settled = minimum.settled
    monkeypatch.setattr(
        minimum, "settled", lambda at, below: rounds.append(at) or settled(at, below=below)
    )
    monkeypatch.setattr(minimum, "SEARCH", replace(SEARCH, deeper_share=share))
    found = deepest_minimum(nominal, local, "shifted")
    assert found.chi2 < local.chi2 and (len(rounds) == 1) is last


def test_run_to_run_variability_is_differenced_both_ways(shifted):
    nominal = shifted.nominal
    model, space = nominal.model, nominal.space
    group = model.groups[0]
    channels = model.simulated(group, nominal.x[np.newaxis], False)[0]
    half_difference, half_sum, _ = run_to_run_rows(model, nominal.x, group, channels)
    place = [each.name for each in space.parameters].index("sled.drag")
    ends = np.repeat(nominal.x[np.newaxis], 3, axis=0)
    ends[1:, place] += np.array([1.0, -1.0]) * RUNS_DIFFER / space.parameters[place].scale
    at, more, less = model.vectors(group, ends, False)
    assert half_difference == pytest.approx(0.5 * (more - less), abs=1e-12)
    assert half_sum == pytest.approx(0.5 * (more + less) - at, abs=1e-12)


def test_about_a_fit_an_effect_is_resized_within_its_range_and_keeps_its_shape():
    ripple = effects()["torque_ripple"]
    space = ParameterSpace(Sled(), [], Settings(), [ripple])
    x = np.zeros(space.size)
    names = [ripple.full_name(name) for name in ("amplitude", "cycles", "phase")]
    amplitude, *shape = (space.place(name) for name in names)
    x[amplitude], x[shape] = 0.9 * space.high[amplitude], (2.0, 3.0)
    point = SimpleNamespace(space=space, x=x)
    smaller, larger = (_resized(point, "torque_ripple", share) for share in (0.8, 1.25))
    assert smaller[amplitude] == pytest.approx(0.8 * x[amplitude])
    assert larger[amplitude] == space.high[amplitude]
    assert (smaller[shape] == x[shape]).all() and (larger[shape] == x[shape]).all()


@kernel
def lopsided(forward, backward, speed):
    """Quadratic drag, by a size above 0 one way and one below 0 the other [N]."""
    return -(forward if speed > 0.0 else -backward) * speed * abs(speed)


LOPSIDED = Effect(
    "lopsided", "made for a test", "F += ...", "none (2026)",
    (
        Parameter("forward", 0.0, "N s^2/m^2", (0.0, 30.0), "ahead", off=0.0),
        Parameter("backward", 0.0, "N s^2/m^2", (-30.0, 0.0), "astern", off=0.0),
    ),
    (Term(lopsided, ("force",)),),
)  # fmt: skip


def test_amplitudes_of_one_side_each_are_tried_each_on_its_own_side():
    entries = [e for e in recordings(4, ((TURBULENCE, 2.0),)) if e.role != "show"]
    found = search_effects(
        Sled(), entries, [KNOWN["hardening"], LOPSIDED], Settings(0.02, 0.005), 0
    )
    steps = stepped(found.baseline, "lopsided", SEARCH.screening_sizes)
    sizes = [each for each in SEARCH.screening_sizes if each > 0.0]
    assert [each.tolist() for each in steps] == [[s, -s] for s in sizes]
    space = found.baseline.space
    point = found.trials[0].point
    values = [point.x[k] * space.parameters[k].scale for k in space.of("lopsided")]
    assert found.trials[0].effects == ("lopsided",)
    assert values == pytest.approx([2.0, -2.0], rel=0.1)
    assert _signatures(found.nominal, ["lopsided"], 8.0)["lopsided"].shape[0] == 2
    assert size_dependent(found.nominal, ["lopsided"]) == []


def test_sizes_that_are_started_are_no_neighbours():
    x = np.zeros(2)
    rows = np.array([[9.0, 0.0], [10.0, 0.0], [8.0, 0.0], [4.0, 0.0], [5.0, 0.0], [0.0, 9.0]])
    assert [row.tolist() for row in global_starts._apart(rows, x)] == [[9, 0], [4, 0], [0, 9]]


def test_a_size_dependent_effect_is_looked_at_in_every_size(monkeypatch):
    """A valley between two of few sizes is seen."""
    seen = {}
    monkeypatch.setattr(global_starts, "part_faults", lambda *_: [])

    def looked_at_sizes(_, name, sizes):
        seen[name] = sizes
        return None, np.ones(1)

    monkeypatch.setattr(global_starts, "looked_at_sizes", looked_at_sizes)
    nominal = SimpleNamespace(space=SimpleNamespace(effects={}))
    global_starts._least(nominal, ["stribeck", "object_misplacement"], ["object_misplacement"], 2.0)
    assert seen == {"stribeck": SEARCH.few_sizes, "object_misplacement": SEARCH.every_size}


@pytest.mark.parametrize("valley", [21.0, 24.0, 37.0, -9.0])
def test_a_fault_is_looked_at_about_its_best_size(monkeypatch, valley):
    """A spring that lost seven tenths: neither half nor all of it lowers the misfit by much."""
    space = SimpleNamespace(
        effects={"worn": None}, low=np.array([-60.0, -60.0]), high=np.array([60.0, 60.0]), size=2,
        place=int,
    )  # fmt: skip
    nominal = SimpleNamespace(space=space, x=np.zeros(2))

    def left(_, name, rows):
        return np.abs(rows[:, 0] - valley) + np.abs(rows[:, 1])

    monkeypatch.setattr(sizes_looked_at, "amplitude_names", lambda effect: ["0", "1"])
    monkeypatch.setattr(sizes_looked_at, "left_at", left)
    sizes = (2.0, 6.0, 14.0, 29.0, 44.0)
    looked = sizes_looked_at.looked_at_sizes(nominal, "worn", sizes)
    rows, found = sizes_looked_at.looked_at_between(nominal, "worn", looked)
    away = min(abs(abs(valley) - each) for each in sizes)
    assert found.min() == left(None, "worn", rows).min() <= 0.5 * away


def test_only_a_fault_that_promises_enough_is_looked_at_between_sizes(monkeypatch):
    """Twenty are tried, and most of them do nothing."""
    left, asked = {"law": 40.0, "near": 60.0, "far": 95.0}, []
    monkeypatch.setattr(global_starts, "part_faults", lambda *_: ["near", "far"])
    monkeypatch.setattr(
        global_starts, "looked_at_sizes", lambda _, name, sizes: (None, np.array([left[name]]))
    )

    def between(_, name, looked):
        asked.append(name)
        return None, 0.5 * looked[1]

    monkeypatch.setattr(global_starts, "looked_at_between", between)
    nominal = SimpleNamespace(space=SimpleNamespace(effects={}))
    least = global_starts._least(nominal, list(left), [], 100.0)
    assert least == {"law": 40.0, "near": 30.0, "far": 95.0} and asked == ["near"]
