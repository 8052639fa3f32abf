"""The parts of a deep diagnosis: slopes, base, gains, drift, noise, shapes, settings."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest
from sled import (
    HARDENING,
    KNOWN,
    NARROW,
    STIFFER,
    TURBULENCE,
    TWIN,
    WAVES,
    WAVES_OF_23,
    Sled,
    found,
    recordings,
)

from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table
from hannes.core.kernels.jit import plain
from hannes.identification.confusability import alike, told
from hannes.identification.diagnosis import decision as choices
from hannes.identification.diagnosis import effect_search, gauss_newton, multistart
from hannes.identification.diagnosis.antedependence import covariance
from hannes.identification.diagnosis.baseline import based
from hannes.identification.diagnosis.campaign_diagnosis import _masks
from hannes.identification.diagnosis.decision import (
    DOUBT,
    MOST,
    OUTSIDE,
    _at_end,
    _explained,
    _pair,
    chosen,
)
from hannes.identification.diagnosis.drift import drifts
from hannes.identification.diagnosis.effect_search import (
    FAINT,
    LIMIT,
    Trial,
    _back,
    _rebased,
    _refuted,
    investigate,
)
from hannes.identification.diagnosis.generic_disturbances import (
    DRAGGING,
    EASING,
    EFFECTS,
    OPENING,
    SPOKEN,
    TORQUE,
)
from hannes.identification.diagnosis.heldout import held_out
from hannes.identification.diagnosis.linearisation import differenced
from hannes.identification.diagnosis.multistart import (
    FADING,
    _crossed,
    faded,
    joined,
    placed,
    without,
)
from hannes.identification.diagnosis.noise_model import Noise, of_repeats, white_levels
from hannes.identification.diagnosis.prior_distance import strain
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.residual_tests import Slow
from hannes.identification.diagnosis.score_test import (
    Guess,
    _twins,
    likeness,
    projected,
    screened,
    shapes,
)
from hannes.identification.diagnosis.settings import Settings, read_settings
from hannes.plants.axis.plant import Axis
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.catalogue import effects


@pytest.fixture(scope="module")
def investigated():
    """What an investigation of hidden turbulence finds."""
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    return investigate(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)


def test_slopes_are_those_of_the_simulation(investigated):
    base = investigated.base
    model, x = base.ground.model, base.x
    vectors, slopes = differenced(model, x, base.active, False)
    moved = x.copy()
    moved[0] += 0.1
    for group, vector, slope in zip(model.groups, vectors, slopes, strict=True):
        there = model.vectors(group, moved[np.newaxis], False)[0]
        moves = 0.1 * slope[0]
        assert there - vector == pytest.approx(moves, abs=0.03 * np.abs(moves).max())


def test_the_base_is_where_nothing_pulls(investigated):
    base = investigated.base
    step = np.linalg.solve(base.curvature, base.pull)
    assert step @ base.curvature @ step < 0.5
    assert base.misfit > 1.5 * base.miss.size  # an effect is missing
    assert investigated.trials[0].point.misfit < 1.2 * base.miss.size


def test_a_base_beside_its_best_place_is_led_back_by_an_effect(investigated):
    base = investigated.base
    beside = base.moved(base.x + 3.0 * np.isin(np.arange(base.x.size), base.active), base.active)
    assert beside.misfit > base.misfit + 20.0
    best, unit = investigated.trials[0], investigated.unit
    back = _back(beside, best, unit, lambda text: None)
    assert back.misfit == pytest.approx(base.misfit, abs=1.0)
    assert _back(base, best, unit, lambda text: None) is None


def test_a_second_effect_that_only_led_the_first_back_is_dropped(investigated, monkeypatch):
    """A fit with the first that stands in a hollow, and a pair that is out of it."""
    best = investigated.trials[0]
    stuck = replace(best, gain=0.5 * best.gain)
    own = best.point.ground.model.space.of("hardening")
    point = placed(best.point, own, np.array([0.01]))
    pair = Trial(("turbulence", "hardening"), point, best.gain)
    monkeypatch.setattr(
        effect_search, "_paired", lambda found, *_: [pair] if found.trials[0] is stuck else []
    )
    monkeypatch.setattr(effect_search, "_paired_from_afar", lambda *_: [])
    found = effect_search._second(replace(investigated, trials=[stuck]), lambda text: None)
    assert found.pair is None
    assert found.trials[0].effects == best.effects
    assert found.trials[0].gain == pytest.approx(best.gain, abs=1.0)


def test_an_effect_is_let_go_little_by_little(investigated, monkeypatch):
    """All else follows after each share, and what is left is the other effect alone."""
    best = investigated.trials[0]
    own = best.point.ground.model.space.of("hardening")
    starts, fitted = [], multistart.fitted
    point = placed(best.point, own, np.array([0.3]))
    monkeypatch.setattr(
        multistart, "fitted", lambda at, *how: starts.append(at) or fitted(at, *how)
    )
    alone = faded(point, "hardening")
    assert alone.misfit == pytest.approx(best.point.misfit, abs=1.0)
    assert np.array_equal(alone.active, best.point.active)
    assert [at.x[own][0] / 0.3 for at in starts] == pytest.approx(FADING)
    monkeypatch.setattr(multistart.Point, "moved", lambda *_: None)
    assert faded(point, "hardening") is None


def test_one_of_a_pair_is_fitted_alone_from_the_machine_as_given_too(investigated, monkeypatch):
    """Where letting the other go leads nowhere."""
    best = investigated.trials[0]
    own = best.point.ground.model.space.of("hardening")
    point = placed(best.point, own, np.array([0.3]))
    pair = Trial(("turbulence", "hardening"), point, 0.0)
    monkeypatch.setattr(effect_search, "faded", lambda *_: None)
    alone = effect_search._alone(investigated, pair, "turbulence", lambda text: None)
    assert alone.effects == ("turbulence",)
    assert alone.gain == pytest.approx(best.gain, abs=1.0)
    assert np.array_equal(alone.point.active, best.point.active)


def test_a_name_that_takes_another_machine_than_was_told_is_not_clean(investigated):
    """The same recordings, told how little is certain and told far too little."""
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    strained = investigate(Sled(), entries, [TURBULENCE], Settings(0.003, 0.005), 0)
    best = strained.trials[0]
    assert strain(investigated.trials[0].point).chance > 0.5
    assert strain(best.point).times > 2.0
    clean, unclean = (
        chosen(found, *(_masks(found, role) for role in ("fit", "select")))
        for found in (investigated, strained)
    )
    assert (clean.kind, clean.effects) == ("named", ("turbulence",))
    assert (unclean.kind, unclean.effects) == ("named_with_remainder", ("turbulence",))
    assert "times as far as scatter tells" in unclean.reason
    base = strained.base  # what is left of it says nothing
    flat = replace(base, miss=np.zeros_like(base.miss), x=np.zeros_like(base.x))
    assert _explained(replace(strained, base=flat), replace(best, gain=20.0)) < MOST
    assert _explained(replace(strained, base=flat), replace(best, gain=1e4)) > MOST


def test_the_machine_takes_over_what_an_effect_did_that_it_can_do_itself():
    """An effect that is one of the machine's parameters by another name leaves no trace."""
    entries = [e for e in recordings(1) if e.role != "show"]
    found = investigate(Sled(), entries, [HARDENING, STIFFER], Settings(0.02, 0.005), 0)
    base, space = found.base, found.base.ground.model.space
    place, own = (
        space.place("stiffer.size"),
        [d.name for d in space.directions].index("spring.stiffness"),
    )
    x = base.x.copy()
    x[place], x[own] = 1.5 / space.directions[place].scale, base.x[own] - 1.5 / 0.8
    bent = base.with_active(np.append(base.active, place)).moved(x, np.array([place]))
    assert bent.misfit == pytest.approx(base.misfit, abs=5.0)
    rows = without(gauss_newton.relinearised(bent), ("stiffer",))
    as_it_is, half, whole = base.misfits(rows)
    assert np.all(rows[:, place] == 0.0)
    assert whole < half < as_it_is
    assert whole - base.misfit < 0.01 * (as_it_is - base.misfit)


def test_what_anything_explains_as_well_has_no_name(investigated):
    best, masks = investigated.trials[0], ([0b011] * 2, [0b100] * 2)
    kinds = {}
    for lost in (5.0, 0.5 * best.gain):
        rival = Trial(("any_torque",), best.point, best.gain - lost)
        kinds[lost] = chosen(replace(investigated, anything=rival), *masks)
    assert [each.kind for each in kinds.values()] == ["unknown", "named"]
    assert "something else may be there" in kinds[5.0].reason


def test_a_rival_without_a_name_that_gains_nothing_itself_doubts_none(investigated):
    masks, kinds = ([0b011] * 2, [0b100] * 2), []
    best = replace(investigated.trials[0], gain=LIMIT + 1.0)
    for gain in (FAINT - 0.1, FAINT + 0.1):
        rival = Trial(("any_torque",), best.point, gain)
        found = replace(investigated, trials=[best], pair=None, anything=rival)
        kinds.append(chosen(found, *masks).kind)
    assert kinds == ["named", "unknown"]


@pytest.mark.parametrize(("gain", "kind"), [(3.0, "unknown"), (70.0, "named_with_remainder")])
def test_of_near_pairs_only_what_explains_much_alone_is_named(investigated, gain, kind):
    """The second effect is in all of them, and may do next to nothing."""
    point = investigated.base
    pairs = [Trial(("a", "b"), point, 130.0), Trial(("c", "b"), point, 128.0)]
    alone = Trial(("b",), point, gain)
    singles = [Trial(("a",), point, 100.0), Trial(("c",), point, 95.0), alone]
    found = replace(investigated, trials=singles, other_pairs=tuple(pairs[1:]))
    choice = _pair(found, pairs[0], "told")
    assert (choice.kind, choice.effects) == (kind, () if kind == "unknown" else ("b",))


def test_what_is_left_is_the_best_refit_of_each_second_effect(investigated):
    point, nothing = investigated.base, np.zeros(0)
    best = Trial(("a",), point, 100.0)
    pairs = [Trial(("a", "b"), point, 109.0), Trial(("a", "b"), point, 102.0)]
    guesses = [Guess("b", 30.0, nothing, nothing, nothing)]
    assert _refuted(best, guesses, pairs, 1.0).gain == pytest.approx(9.0)


def test_a_plant_whose_values_are_the_same_in_all_runs_can_be_refitted():
    class Steady(Sled):
        run_to_run: ClassVar = {}

    entries = [e for e in recordings(1) if e.role != "show"]
    plant = Steady()
    _, base = based(plant, grouped(plant, entries), Settings(0.02, 0.005), [], 0, lambda text: None)
    assert [rows.shape[0] for rows in base.ground.restless] == [1, 1]  # their start alone


def test_what_explains_less_than_stands_out_in_one_channel_has_no_name(investigated, monkeypatch):
    best, masks = investigated.trials[0], ([0b011] * 2, [0b100] * 2)
    lowered, kinds = investigated.base.misfit - best.point.misfit, {}
    for share in (1.2, 1.3, 1.5):
        slow = Slow("the position of runs like slow", share * lowered, 1e-9)
        monkeypatch.setattr(choices, "stands_out", lambda point, slow=slow: slow)
        kinds[share] = chosen(investigated, *masks)
    found = [each.kind for each in kinds.values()]
    assert found == ["named", "unknown", "unknown"]
    assert "stand out in the position of runs like slow alone" in kinds[1.5].reason


def test_a_base_of_which_something_stands_out_is_no_mere_recalibration(monkeypatch):
    entries = [e for e in recordings(3) if e.role != "show"]
    empty = investigate(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    masks = ([0b011] * 2, [0b100] * 2)
    assert chosen(replace(empty, trials=[]), *masks).kind == "recalibrated"
    slow = Slow("the position of runs like slow", 50.0, 1e-9)
    monkeypatch.setattr(choices, "stands_out", lambda point: slow)
    verdict = chosen(replace(empty, trials=[]), *masks)
    assert verdict.kind == "unknown"
    assert "more in the position of runs like slow than" in verdict.reason


def test_an_effect_that_would_leave_its_range_has_no_name():
    hidden = ((TURBULENCE, 2.0),)
    assert found(1, hidden, {"turbulence": TURBULENCE}).verdict == "named"
    verdict = found(1, hidden, {"turbulence": NARROW})
    assert verdict.verdict == "unknown"
    assert "turbulence's size at an end of its range and beyond" in verdict.reason


def test_what_ends_nowhere_is_at_no_end():
    ripple = {each.name: each for each in effects()["torque_ripple"].parameters}
    ends = {name: [_at_end(each, end) for end in each.bounds] for name, each in ripple.items()}
    assert ends == {
        "amplitude": [False, True],
        "cycles": [False, False],
        "phase": [False, False],
    }


def test_what_has_no_name_is_in_no_catalogue_and_fits_a_hand():
    assert list(SPOKEN) == [each.name for each in EFFECTS]
    assert not set(SPOKEN) & set(effects())
    assert not any(HandPlant().accepts(each) for each in EFFECTS)


def test_any_torque_is_series_of_the_angle_and_of_the_load():
    sizes = {each.name: 0.1 * k for k, each in enumerate(TORQUE.parameters, 1)}
    turn, load = np.pi * 3.0 / 10.0, 0.2
    free = sum(0.1 * k * np.cos(k * turn) for k in range(1, 6))
    loaded = sum(0.1 * (k + 5) * np.cos(k * turn) for k in range(1, 5))
    told = plain(TORQUE.terms[0].kernel)(3.0 * 19.0, 19.0, load, **sizes)
    assert told == pytest.approx(free + load * loaded, rel=1e-12)


def test_any_opening_is_a_series_of_the_way_that_a_joint_has_closed():
    bent = {each.name: 0.1 * k for k, each in enumerate(OPENING.parameters, 1)}
    assert list(bent) == ["bent_2", "bent_3", "bent_4"]
    opening = plain(OPENING.terms[0].kernel)(0.9, 0.3, **bent)
    series = np.polynomial.legendre.legval(2.0 * (0.9 - 0.3) / 1.5 - 1.0, [0, 0, *bent.values()])
    assert opening == pytest.approx(series, rel=1e-12)


def test_any_dragging_turns_with_the_way_a_joint_goes():
    drag = {each.name: 0.1 * k for k, each in enumerate(DRAGGING.parameters, 1)}
    assert list(drag) == ["drag_1", "drag_2", "drag_3"]
    kernel, series = plain(DRAGGING.terms[0].kernel), np.polynomial.legendre.legval
    against = series(2.0 * (0.9 - 0.3) / 1.5 - 1.0, [0, *drag.values()])
    told = [kernel(0.9, speed, 0.3, **drag) for speed in (-5.0, 0.0, 5.0)]
    assert told == pytest.approx([-against, 0.0, against], rel=1e-12)


def test_what_eases_is_lost_exponentially_and_never_more_than_the_pull():
    kernel, eased, step = plain(EASING.terms[0].kernel), 0.0, 1e-3
    for _ in range(2000):
        change, rate = kernel(30.0, eased, 0.5)
        eased += step * rate
    assert change == pytest.approx(-30.0 * (1.0 - np.exp(-0.5 * 2.0)), rel=1e-3)
    assert kernel(1.0, eased, 0.5) == (-1.0, 0.0)


def test_beside_a_better_base_every_effect_gains_less(investigated):
    better = replace(investigated.base, miss=0.999 * investigated.base.miss)
    rebased = _rebased(investigated, better)
    lost = (investigated.base.misfit - better.misfit) / investigated.unit
    below = [each for each in investigated.trials if each.point.misfit < better.misfit]
    gains = {each.effects: each.gain - lost for each in below}
    assert {each.effects: each.gain for each in rebased.trials} == pytest.approx(gains)
    assert ("turbulence",) in gains
    assert lost > 0.0 and rebased.base is better


def test_a_rival_that_went_astray_starts_from_the_machine_of_the_best(monkeypatch):
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    both = investigate(Sled(), entries, [TURBULENCE, TWIN], Settings(0.02, 0.005), 0)
    base, space = both.base, both.base.ground.model.space
    points = {each.effects[0]: each.point for each in both.trials}
    twin, first = points["twin"], points["turbulence"]
    moved = twin.x + 0.5 * np.isin(np.arange(twin.x.size), base.active)
    points["twin"] = twin.moved(moved, space.of("twin"))
    starts, settled = [], multistart.settled
    monkeypatch.setattr(
        multistart, "settled", lambda at, *how: starts.append(at) or settled(at, *how)
    )
    again = _crossed(points, base, LIMIT, lambda text: None)
    assert again["twin"].misfit == pytest.approx(twin.misfit, abs=0.5)
    assert again["turbulence"] is first
    assert np.array_equal(starts[0].x[base.active], first.x[base.active])
    assert starts[0].x[space.of("twin")] == twin.x[space.of("twin")]
    starts.clear()
    _crossed(points, base, 2.0 * base.misfit, lambda text: None)
    assert not starts  # none gains as much as that


def test_rounds_of_slopes_end_where_they_cannot_arrive(investigated, monkeypatch):
    rounds, relinearised = [], gauss_newton.relinearised
    monkeypatch.setattr(
        gauss_newton, "relinearised", lambda at: rounds.append(at) or relinearised(at)
    )
    base = investigated.base
    beside = base.moved(base.x + 3.0 * np.isin(np.arange(base.x.size), base.active), base.active)
    gauss_newton.settled(beside)
    assert len(rounds) > 1
    rounds.clear()
    gauss_newton.settled(beside, below=base.misfit - 2.0 * (beside.misfit - base.misfit))
    assert len(rounds) == 1


def test_a_gain_is_of_what_was_not_fitted_too(investigated):
    base, best = investigated.base, investigated.trials[0].point
    seen, unseen = ([0b011] * 2, [0b100] * 2)
    assert held_out(base, best, seen, unseen) > LIMIT
    assert held_out(base, base, seen, unseen) == 0.0
    assert held_out(base, best, seen, [0, 0]) == 0.0


def test_what_grows_from_run_to_run_is_no_clean_name():
    verdict = found(1, ((TURBULENCE, 0.02),), growth=1.0)
    assert verdict.verdict in ("unknown", "named_with_remainder")
    assert "from run to run" in verdict.reason


def test_what_does_not_grow_does_not_drift(investigated):
    best = investigated.trials[0].point
    assert drifts(best, investigated.guesses).gain < LIMIT
    assert drifts(investigated.base, investigated.guesses).gain < 0.95 * investigated.trials[0].gain


def test_a_guess_agrees_with_the_refit_where_an_effect_is_small():
    entries = [e for e in recordings(1, ((TURBULENCE, 0.5),)) if e.role != "show"]
    small = investigate(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    guess = next(each for each in small.guesses if each.effect == "turbulence")
    trial = next(each for each in small.trials if each.effects == ("turbulence",))
    assert guess.gain == pytest.approx(trial.gain * small.unit, rel=0.1)
    again = {g.effect: g.gain for g in screened(trial.point, ["hardening"])}
    assert again["hardening"] < LIMIT


def test_what_parameters_can_do_is_no_mark_of_an_effect(investigated):
    base = investigated.base
    row = base.columns[:1]
    _, curvature = projected(base, row)
    assert curvature[0, 0] < 1.01  # as much as the given value's own spread leaves of it
    assert likeness(base, row, row) == pytest.approx(1.0, abs=1e-3)


def test_noise_that_hangs_together_is_found_and_is_a_covariance():
    groups = grouped(Sled(), recordings(1))
    rng = np.random.default_rng(5)
    for group in groups:
        white = rng.standard_normal((group.count, group.part.size + 9))
        smooth = np.apply_along_axis(np.convolve, 1, white, np.ones(10) / np.sqrt(10.0), "valid")
        group.measured = 1e-2 * smooth
    none = [np.zeros((1, group.part.size)) for group in groups]
    calm = [each[0] for each in none]
    noise = Noise(groups, *of_repeats(groups, calm, none, 1.0), calm, none, 1.0)
    for group in groups:
        covariance = noise.covariance(group)
        assert np.linalg.eigvalsh(covariance).min() > 0.0
        near = np.diag(covariance, 1)[: group.bins - 1] / np.diag(covariance)[: group.bins - 1]
        assert 0.6 < near.mean() < 1.0
        assert np.sqrt(np.diag(covariance)).mean() == pytest.approx(1e-2, rel=0.3)


def test_noise_without_repeats_is_how_rough_samples_are():
    groups = grouped(Sled(), [recordings(1)[0], recordings(1)[4]])
    levels = white_levels(groups[0], {})
    per_bin = 2e-3 / np.sqrt(groups[0].recording.time.size / groups[0].bins)
    assert levels["position"] == pytest.approx(per_bin, rel=0.15)


def test_noise_hangs_together_as_it_does_at_its_time():
    rng = np.random.default_rng(5)
    quick, slow = rng.standard_normal((2, 2000, 60))
    for bin in range(1, 60):  # alone first, then each after the one before
        slow[:, bin] = 0.875 * slow[:, bin - 1] + np.sqrt(1.0 - 0.875**2) * slow[:, bin]
    strays = np.hstack([quick[:, :30], slow[:, 30:]])
    found, beside = covariance(strays, 1), np.arange(8, 22)
    assert np.diag(found)[8:52] == pytest.approx(np.ones(44), abs=0.15)
    assert found[beside, beside + 1] == pytest.approx(np.zeros(14), abs=0.1)
    assert found[beside + 30, beside + 31] == pytest.approx(np.full(14, 0.875), abs=0.1)
    assert np.linalg.eigvalsh(found).min() > 0.0


def test_forty_runs_tell_how_little_a_loop_lets_slow_changes_be():
    # Differences of white noise: their sum over a run is no more than one of them. Two channels,
    # the second what the first was before.
    rng = np.random.default_rng(6)
    white = rng.standard_normal((40, 101))
    one = np.diff(white)
    strays = np.hstack([one, np.pad(one, ((0, 0), (1, 0)))[:, :-1]])
    found = covariance(strays, 2)
    slow = np.cos(np.pi * (np.arange(100) + 0.5) / 50.0) / np.sqrt(50.0)
    told, usual = slow @ found[:100, :100] @ slow, 2.0
    assert told < 0.05 * usual  # 0.001 if it were known; a taper of 0.6 s leaves 0.3
    assert np.diag(found) == pytest.approx(np.full(200, usual), rel=0.4, abs=0.1)
    assert found[10:90, 111:191].diagonal() == pytest.approx(np.full(80, usual), rel=0.4)


def test_a_phase_and_its_opposite_are_tried_by_one_mark():
    ripple = effects()["torque_ripple"]
    (quarter,) = [each for each in shapes(ripple) if list(each.values()) == [3.0, np.pi / 2.0]]
    (same, as_is), (opposite, turned) = _twins(ripple, quarter)
    assert (same, as_is, turned) == (quarter, 1.0, -1.0)
    assert opposite["torque_ripple.phase"] == pytest.approx(1.5 * np.pi)
    kernel = plain(ripple.terms[0].kernel)
    marks = [kernel(0.7, 1e-3, *each.values()) for each in (quarter, opposite)]
    assert marks[1] == pytest.approx(-marks[0], rel=1e-12)


def test_what_is_too_faint_to_name_is_unknown():
    entries = [e for e in recordings(3) if e.role != "show"]
    empty = investigate(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    for gain, kind in ((DOUBT - 0.1, "recalibrated"), (DOUBT, "unknown"), (LIMIT, "named")):
        trial = Trial(("hardening",), empty.base, gain)
        choice = chosen(replace(empty, trials=[trial]), [0b011] * 2, [0b100] * 2)
        assert choice.kind == kind
        assert (f"where a name needs {LIMIT:.0f}" in choice.reason) == (kind == "unknown")
    for gain, kind in ((OUTSIDE - 0.1, "recalibrated"), (OUTSIDE, "unknown")):
        rival = Trial(("any_torque",), empty.base, gain)
        choice = chosen(replace(empty, trials=[], anything=rival), [0b011] * 2, [0b100] * 2)
        assert choice.kind == kind
        assert choice.reason.startswith("any torque over") == (kind == "unknown")


def test_a_guess_that_goes_too_far_is_begun_at_a_share():
    entries = [e for e in recordings(3, ((HARDENING, 900.0),)) if e.role != "show"]
    found = investigate(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    base, (guess,) = found.base, [g for g in found.guesses if g.effect == "hardening"]
    far = replace(guess, x=20.0 * guess.x)
    whole, part = placed(base, far.places, far.x), joined(base, far)
    assert part.misfit < 0.5 * whole.misfit
    assert part.x[far.places] == pytest.approx(0.05 * far.x)


def test_a_shape_that_is_a_count_is_found():
    verdict = found(1, ((WAVES_OF_23, 0.05),), {"washboard": WAVES})
    assert verdict.effects == ["washboard"]
    assert verdict.parameters["washboard.count"]["value"] == pytest.approx(23.0, abs=0.2)


def test_shapes_lie_inside_the_bounds():
    for each in effects().values():
        for shape in shapes(each):
            for name, value in shape.items():
                low, high = next(
                    p.bounds for p in each.parameters if each.full_name(p.name) == name
                )
                assert low <= value <= high
        assert shapes(each)


def test_a_plant_with_nothing_uncertain_is_not_told_how_much_of_it():
    with pytest.raises(BadInput, match="does not say what is uncertain"):
        read_settings(Table({"scatter": "2 %"}, "campaign.toml", (), "diagnose."), Axis())


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"scatter": "2"}, "scatter"),
        ({"scatter": "80 %"}, "between 0 and 50 %"),
        ({"scater": "2 %"}, "scatter"),
        ({"start_time": "2 mm"}, "start_time"),
        ({"start_time": "-1 ms"}, "not negative"),
    ],
)
def test_what_a_campaign_says_of_its_machine_is_checked(content, message):
    with pytest.raises(BadInput, match=message):
        read_settings(Table(content, "campaign.toml", (), "diagnose."), Sled())


def test_what_is_easily_confused_was_measured_both_ways():
    for effect in effects():
        for recorded, others in alike(effect).items():
            assert list(others.values()) == sorted(others.values(), reverse=True)
            for other, cosine in others.items():
                assert 0.0 < cosine <= 1.0
                assert alike(other)[recorded][effect] == pytest.approx(cosine, abs=2e-3)
    assert "capstan" in told("gear_load")
    assert told("nobody_knows") == ""
