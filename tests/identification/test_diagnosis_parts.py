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
    investigation,
    recordings,
)

from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table
from hannes.core.kernels.jit import plain
from hannes.identification.confusability import confusable, text
from hannes.identification.diagnosis import decision as choices
from hannes.identification.diagnosis import (
    effect_removal,
    further_effects,
    gauss_newton,
    multistart,
    reservations,
)
from hannes.identification.diagnosis.antedependence import covariance
from hannes.identification.diagnosis.baseline import based
from hannes.identification.diagnosis.better_baseline import better_baseline
from hannes.identification.diagnosis.decision import _several, decide
from hannes.identification.diagnosis.effect_search import _rebased, search_effects
from hannes.identification.diagnosis.further_effects import _refuted
from hannes.identification.diagnosis.generic_disturbances import (
    DRAGGING,
    EASING,
    EFFECTS,
    GENERIC_NAMES,
    OPENING,
    TORQUE,
)
from hannes.identification.diagnosis.heldout import heldout_reduction, runs_in_role
from hannes.identification.diagnosis.linearisation import differenced
from hannes.identification.diagnosis.multistart import (
    _crossed,
    faded,
    started_at,
    started_at_guess,
    without,
)
from hannes.identification.diagnosis.noise_model import Noise, of_repeats, white_levels
from hannes.identification.diagnosis.prior_distance import prior_distance
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.reservations import _at_end, explained_share
from hannes.identification.diagnosis.residual_tests import StructuredResidual
from hannes.identification.diagnosis.score_test import (
    Guess,
    _twins,
    cosine_similarity,
    projected,
    screened,
    shapes,
)
from hannes.identification.diagnosis.settings import Settings, read_settings
from hannes.identification.diagnosis.trend import strongest_trend
from hannes.identification.diagnosis.trials import Joint, Trial
from hannes.identification.diagnosis.tuning import SEARCH, VERDICT
from hannes.plants.axis.plant import Axis
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.catalogue import effects


@pytest.fixture(scope="module")
def investigated():
    return investigation()


def test_derivatives_are_those_of_the_simulation(investigated):
    baseline = investigated.baseline
    model, x = baseline.model, baseline.x
    vectors, derivatives = differenced(model, x, baseline.active, False)
    moved = x.copy()
    moved[0] += 0.1
    for group, vector, slope in zip(model.groups, vectors, derivatives, strict=True):
        there = model.vectors(group, moved[np.newaxis], False)[0]
        moves = 0.1 * slope[0]
        assert there - vector == pytest.approx(moves, abs=0.03 * np.abs(moves).max())


def test_the_baseline_has_zero_gradient(investigated):
    baseline = investigated.baseline
    step = np.linalg.solve(baseline.hessian, baseline.gradient)
    assert step @ baseline.hessian @ step < 0.5
    assert baseline.chi2 > 1.5 * baseline.residual.size  # an effect is missing
    assert investigated.trials[0].point.chi2 < 1.2 * baseline.residual.size


def test_a_baseline_beside_its_minimum_is_led_back_by_an_effect(investigated):
    baseline = investigated.baseline
    beside = baseline.moved(
        baseline.x + 3.0 * np.isin(np.arange(baseline.x.size), baseline.active), baseline.active
    )
    assert beside.chi2 > baseline.chi2 + 20.0
    best, unit = investigated.trials[0], investigated.variance_factor
    asked = (best.point, best.effects, unit, lambda text: None)
    back = better_baseline(beside, *asked)
    assert back.chi2 == pytest.approx(baseline.chi2, abs=1.0)
    assert better_baseline(baseline, *asked) is None


def test_a_second_effect_that_only_led_the_first_back_is_dropped(investigated, monkeypatch):
    """A fit with the first effect in a local minimum, and a pair that is out of it."""
    best = investigated.trials[0]
    stuck = replace(best, delta_chi2=0.5 * best.delta_chi2)
    own = best.point.space.of("hardening")
    point = started_at(best.point, own, np.array([0.01]))
    pair = Trial(("turbulence", "hardening"), point, best.delta_chi2)
    monkeypatch.setattr(
        further_effects,
        "_enlarged",
        lambda found, best, *_: [pair] if best is stuck else [],
    )
    found = further_effects.with_further_effects(
        replace(investigated, trials=[stuck]), lambda text: None
    )
    assert found.joint is None
    assert found.trials[0].effects == best.effects
    assert found.trials[0].delta_chi2 == pytest.approx(best.delta_chi2, abs=1.0)


def test_an_effect_is_let_go_little_by_little(investigated, monkeypatch):
    """All else follows after each share, and what is left is the other effect alone."""
    best = investigated.trials[0]
    own = best.point.space.of("hardening")
    starts, fitted = [], multistart.fitted
    point = started_at(best.point, own, np.array([0.3]))
    monkeypatch.setattr(
        multistart, "fitted", lambda at, *how: starts.append(at) or fitted(at, *how)
    )
    alone = faded(point, "hardening")
    assert alone.chi2 == pytest.approx(best.point.chi2, abs=1.0)
    assert np.array_equal(alone.active, best.point.active)
    assert [at.x[own][0] / 0.3 for at in starts] == pytest.approx(SEARCH.fading_shares)
    monkeypatch.setattr(multistart.Linearisation, "moved", lambda *_: None)
    assert faded(point, "hardening") is None


def test_one_of_a_pair_is_fitted_alone_from_the_machine_as_given_too(investigated, monkeypatch):
    """Where letting the other go leads nowhere."""
    best = investigated.trials[0]
    own = best.point.space.of("hardening")
    point = started_at(best.point, own, np.array([0.3]))
    pair = Trial(("turbulence", "hardening"), point, 0.0)
    monkeypatch.setattr(effect_removal, "faded", lambda *_: None)
    alone = effect_removal.left_out(investigated, pair, "hardening", lambda text: None)
    assert alone.effects == ("turbulence",)
    assert alone.delta_chi2 == pytest.approx(best.delta_chi2, abs=1.0)
    assert np.array_equal(alone.point.active, best.point.active)


def test_a_name_that_needs_an_improbable_machine_is_not_clean(investigated):
    """The same recordings with the true scatter and with far too little of it."""
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    far = search_effects(Sled(), entries, [TURBULENCE], Settings(0.003, 0.005), 0)
    best = far.trials[0]
    assert prior_distance(investigated.trials[0].point).p_value > 0.5
    assert prior_distance(best.point).ratio > 2.0
    clean, unclean = (
        decide(
            found, *(runs_in_role(found.baseline.model.groups, role) for role in ("fit", "select"))
        )
        for found in (investigated, far)
    )
    assert (clean.kind, clean.effects) == ("named", ("turbulence",))
    assert (unclean.kind, unclean.effects) == ("named_with_remainder", ("turbulence",))
    assert "times as far as scatter allows" in unclean.reason
    for lowered, enough in ((20.0, False), (1e4, True)):
        residual = np.zeros_like(far.baseline.residual)
        residual[0] = np.sqrt(best.point.chi2 + lowered)
        higher = replace(far.baseline, residual=residual, x=np.zeros_like(far.baseline.x))
        explained = explained_share(replace(far, baseline=higher), best)
        assert (explained > VERDICT.explained_share) is enough


def test_of_a_large_effect_all_is_explained_although_noise_alone_is_scaled(investigated):
    """What runs differ by is not: reductions in the noise that is there are no simple multiples."""
    found = replace(investigated, variance_factor=0.7)
    best = replace(found.trials[0], delta_chi2=0.9 * found.trials[0].delta_chi2 / 0.7)
    assert explained_share(found, best) == pytest.approx(
        explained_share(investigated, investigated.trials[0]), abs=0.01
    )


def test_the_machine_takes_over_what_an_effect_did_that_it_can_do_itself():
    """An effect that is one of the machine's parameters by another name leaves no trace."""
    entries = [e for e in recordings(1) if e.role != "show"]
    found = search_effects(Sled(), entries, [HARDENING, STIFFER], Settings(0.02, 0.005), 0)
    baseline, space = found.baseline, found.baseline.space
    place, own = (
        space.place("stiffer.size"),
        [d.name for d in space.parameters].index("spring.stiffness"),
    )
    x = baseline.x.copy()
    x[place], x[own] = 1.5 / space.parameters[place].scale, baseline.x[own] - 1.5 / 0.8
    absorbed = baseline.with_active(np.append(baseline.active, place)).moved(x, np.array([place]))
    assert absorbed.chi2 == pytest.approx(baseline.chi2, abs=5.0)
    rows = without(gauss_newton.relinearised(absorbed), ("stiffer",))
    as_it_is, half, whole = baseline.chi2_at(rows)
    assert np.all(rows[:, place] == 0.0)
    assert whole < half < as_it_is
    assert whole - baseline.chi2 < 0.01 * (as_it_is - baseline.chi2)


def test_what_a_generic_disturbance_explains_as_well_has_no_name(investigated):
    best, masks = investigated.trials[0], ([0b011] * 2, [0b100] * 2)
    kinds = {}
    for lost in (5.0, 0.5 * best.delta_chi2):
        rival = Trial(("any_torque",), best.point, best.delta_chi2 - lost)
        kinds[lost] = decide(replace(investigated, generic=rival), *masks)
    assert [each.kind for each in kinds.values()] == ["unknown", "named"]
    assert "something else may be there" in kinds[5.0].reason


def test_a_generic_disturbance_that_does_far_less_is_no_rival(investigated):
    masks, kinds = ([0b011] * 2, [0b100] * 2), []
    best = replace(investigated.trials[0], delta_chi2=SEARCH.name_limit + 1.0)
    for apart in (SEARCH.rival + 0.1, SEARCH.rival - 0.1):
        delta_chi2 = max(best.delta_chi2 - apart, SEARCH.faint)
        rival = Trial(("any_torque",), best.point, delta_chi2)
        found = replace(investigated, trials=[best], joint=None, generic=rival)
        kinds.append(decide(found, *masks).kind)
    assert kinds == ["named", "unknown"]


@pytest.mark.parametrize(("delta_chi2", "kind"), [(3.0, "unknown"), (70.0, "named_with_remainder")])
def test_of_near_pairs_only_what_explains_much_alone_is_named(investigated, delta_chi2, kind):
    """The second effect is in all of them, and may do next to nothing."""
    point = investigated.baseline
    pairs = [Trial(("a", "b"), point, 130.0), Trial(("c", "b"), point, 128.0)]
    alone = Trial(("b",), point, delta_chi2)
    singles = [Trial(("a",), point, 100.0), Trial(("c",), point, 95.0), alone]
    joint = Joint(pairs[0], losses={"a": 30.0, "b": 30.0}, others=tuple(pairs[1:]))
    decision = _several(replace(investigated, trials=singles, joint=joint), joint, "reason")
    assert (decision.kind, decision.effects) == (kind, () if kind == "unknown" else ("b",))


def test_what_is_left_is_the_best_refit_of_each_second_effect(investigated):
    point, nothing = investigated.baseline, np.zeros(0)
    best = Trial(("a",), point, 100.0)
    pairs = [Trial(("a", "b"), point, 109.0), Trial(("a", "b"), point, 102.0)]
    guesses = [Guess("b", 30.0, nothing, nothing, nothing)]
    assert _refuted(best, guesses, pairs, 1.0).delta_chi2 == pytest.approx(9.0)


def test_a_plant_whose_values_are_the_same_in_all_runs_can_be_refitted():
    class Steady(Sled):
        run_to_run: ClassVar = {}

    entries = [e for e in recordings(1) if e.role != "show"]
    plant = Steady()
    _, baseline = based(
        plant, grouped(plant, entries), Settings(0.02, 0.005), [], 0, lambda text: None
    )
    assert [rows.shape[0] for rows in baseline.noise.run_to_run] == [1, 1]  # their start alone


def test_what_explains_less_than_stands_out_in_one_channel_has_no_name(investigated, monkeypatch):
    best, masks = investigated.trials[0], ([0b011] * 2, [0b100] * 2)
    chi2_reduction, kinds = investigated.baseline.chi2 - best.point.chi2, {}
    for share in (1.2, 1.3, 1.5):
        slow = StructuredResidual("the position of runs like slow", share * chi2_reduction, 1e-9)
        monkeypatch.setattr(reservations, "channel_excess", lambda point, slow=slow: slow)
        kinds[share] = decide(investigated, *masks)
    found = [each.kind for each in kinds.values()]
    assert found == ["named", "unknown", "unknown"]
    assert "stand out in the position of runs like slow alone" in kinds[1.5].reason


def test_a_base_of_which_something_stands_out_is_no_mere_recalibration(monkeypatch):
    entries = [e for e in recordings(3) if e.role != "show"]
    empty = search_effects(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    masks = ([0b011] * 2, [0b100] * 2)
    assert decide(replace(empty, trials=[]), *masks).kind == "recalibrated"
    slow = StructuredResidual("the position of runs like slow", 50.0, 1e-9)
    monkeypatch.setattr(choices, "channel_excess", lambda point: slow)
    verdict = decide(replace(empty, trials=[]), *masks)
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
    assert list(GENERIC_NAMES) == [each.name for each in EFFECTS]
    assert not set(GENERIC_NAMES) & set(effects())
    assert not any(HandPlant().accepts(each) for each in EFFECTS)


def test_any_torque_is_series_of_the_angle_and_of_the_load():
    sizes = {each.name: 0.1 * k for k, each in enumerate(TORQUE.parameters, 1)}
    turn, load = np.pi * 3.0 / 10.0, 0.2
    free = sum(0.1 * k * np.cos(k * turn) for k in range(1, 6))
    loaded = sum(0.1 * (k + 5) * np.cos(k * turn) for k in range(1, 5))
    found_value = plain(TORQUE.terms[0].kernel)(3.0 * 19.0, 19.0, load, **sizes)
    assert found_value == pytest.approx(free + load * loaded, rel=1e-12)


def test_any_opening_is_a_series_of_the_way_that_a_joint_has_closed():
    absorbed = {each.name: 0.1 * k for k, each in enumerate(OPENING.parameters, 1)}
    assert list(absorbed) == ["legendre_2", "legendre_3", "legendre_4"]
    opening = plain(OPENING.terms[0].kernel)(0.9, 0.3, **absorbed)
    series = np.polynomial.legendre.legval(
        2.0 * (0.9 - 0.3) / 1.5 - 1.0, [0, 0, *absorbed.values()]
    )
    assert opening == pytest.approx(series, rel=1e-12)


def test_any_dragging_turns_with_the_way_a_joint_goes():
    drag = {each.name: 0.1 * k for k, each in enumerate(DRAGGING.parameters, 1)}
    assert list(drag) == ["drag_1", "drag_2", "drag_3"]
    kernel, series = plain(DRAGGING.terms[0].kernel), np.polynomial.legendre.legval
    against = series(2.0 * (0.9 - 0.3) / 1.5 - 1.0, [0, *drag.values()])
    found_value = [kernel(0.9, speed, 0.3, **drag) for speed in (-5.0, 0.0, 5.0)]
    assert found_value == pytest.approx([-against, 0.0, against], rel=1e-12)


def test_what_eases_is_lost_exponentially_and_never_more_than_the_pull():
    kernel, eased, step = plain(EASING.terms[0].kernel), 0.0, 1e-3
    for _ in range(2000):
        change, rate = kernel(30.0, eased, 0.5)
        eased += step * rate
    assert change == pytest.approx(-30.0 * (1.0 - np.exp(-0.5 * 2.0)), rel=1e-3)
    assert kernel(1.0, eased, 0.5) == (-1.0, 0.0)


def test_beside_a_better_base_every_effect_gains_less(investigated):
    better = replace(investigated.baseline, residual=0.999 * investigated.baseline.residual)
    rebased = _rebased(investigated, better)
    lost = (investigated.baseline.chi2 - better.chi2) / investigated.variance_factor
    below = [each for each in investigated.trials if each.point.chi2 < better.chi2]
    reductions = {each.effects: each.delta_chi2 - lost for each in below}
    assert {each.effects: each.delta_chi2 for each in rebased.trials} == pytest.approx(reductions)
    assert ("turbulence",) in reductions
    assert lost > 0.0 and rebased.baseline is better


def test_a_rival_that_went_astray_starts_from_the_machine_of_the_best(monkeypatch):
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    both = search_effects(Sled(), entries, [TURBULENCE, TWIN], Settings(0.02, 0.005), 0)
    baseline, space = both.baseline, both.baseline.space
    points = {each.effects[0]: each.point for each in both.trials}
    twin, first = points["twin"], points["turbulence"]
    moved = twin.x + 0.5 * np.isin(np.arange(twin.x.size), baseline.active)
    points["twin"] = twin.moved(moved, space.of("twin"))
    starts, settled = [], multistart.settled
    monkeypatch.setattr(
        multistart, "settled", lambda at, *how: starts.append(at) or settled(at, *how)
    )
    again = _crossed(points, baseline, SEARCH.name_limit, lambda text: None)
    assert again["twin"].chi2 == pytest.approx(twin.chi2, abs=0.5)
    assert again["turbulence"] is first
    own = baseline.active
    assert starts[0].x[own] == pytest.approx(first.x[own], abs=0.01)  # was 0.5 from there
    assert starts[0].x[space.of("twin")] == pytest.approx(twin.x[space.of("twin")], rel=1e-3)
    starts.clear()
    _crossed(points, baseline, 2.0 * baseline.chi2, lambda text: None)
    assert not starts  # none gains as much as that


def test_rounds_of_slopes_end_where_they_cannot_arrive(investigated, monkeypatch):
    rounds, relinearised = [], gauss_newton.relinearised
    monkeypatch.setattr(
        gauss_newton, "relinearised", lambda at: rounds.append(at) or relinearised(at)
    )
    baseline = investigated.baseline
    beside = baseline.moved(
        baseline.x + 3.0 * np.isin(np.arange(baseline.x.size), baseline.active), baseline.active
    )
    there = gauss_newton.settled(beside)
    assert len(rounds) > 1
    rounds.clear()
    assert gauss_newton.settled(there) is there and not rounds  # it has converged
    gauss_newton.settled(replace(there, last_reduction=np.inf))
    assert rounds
    rounds.clear()
    gauss_newton.settled(beside, below=baseline.chi2 - 2.0 * (beside.chi2 - baseline.chi2))
    assert len(rounds) == 1


def test_a_gain_is_of_what_was_not_fitted_too(investigated):
    baseline, best = investigated.baseline, investigated.trials[0].point
    fitted_runs, heldout_runs = ([0b011] * 2, [0b100] * 2)
    assert heldout_reduction(baseline, best, fitted_runs, heldout_runs) > SEARCH.name_limit
    assert heldout_reduction(baseline, baseline, fitted_runs, heldout_runs) == 0.0
    assert heldout_reduction(baseline, best, fitted_runs, [0, 0]) == 0.0


def test_a_trend_across_runs_is_no_clean_name():
    verdict = found(1, ((TURBULENCE, 0.02),), growth=1.0)
    assert verdict.verdict in ("unknown", "named_with_remainder")
    assert "from run to run" in verdict.reason


def test_what_does_not_grow_is_no_trend(investigated):
    best = investigated.trials[0].point
    assert strongest_trend(best, investigated.guesses).delta_chi2 < SEARCH.name_limit
    assert (
        strongest_trend(investigated.baseline, investigated.guesses).delta_chi2
        < 0.95 * investigated.trials[0].delta_chi2
    )


def test_a_guess_agrees_with_the_refit_where_an_effect_is_small():
    entries = [e for e in recordings(1, ((TURBULENCE, 0.5),)) if e.role != "show"]
    small = search_effects(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    guess = next(each for each in small.guesses if each.effect == "turbulence")
    trial = next(each for each in small.trials if each.effects == ("turbulence",))
    assert guess.delta_chi2 == pytest.approx(trial.delta_chi2 * small.variance_factor, rel=0.1)
    again = {g.effect: g.delta_chi2 for g in screened(trial.point, ["hardening"])}
    assert again["hardening"] < SEARCH.name_limit


def test_what_parameters_can_do_is_no_signature_of_an_effect(investigated):
    baseline = investigated.baseline
    row = baseline.jacobian[:1]
    _, hessian = projected(baseline, row)
    assert hessian[0, 0] < 1.01  # as much as the given value's own spread leaves of it
    assert cosine_similarity(baseline, row, row) == pytest.approx(1.0, abs=1e-3)


def test_correlated_noise_is_found_and_is_a_covariance():
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


def test_noise_is_correlated_as_it_is_at_its_time():
    rng = np.random.default_rng(5)
    quick, slow = rng.standard_normal((2, 2000, 60))
    for bin in range(1, 60):  # alone first, then each after the one before
        slow[:, bin] = 0.875 * slow[:, bin - 1] + np.sqrt(1.0 - 0.875**2) * slow[:, bin]
    deviations = np.hstack([quick[:, :30], slow[:, 30:]])
    found, beside = covariance(deviations, 1), np.arange(8, 22)
    assert np.diag(found)[8:52] == pytest.approx(np.ones(44), abs=0.15)
    assert found[beside, beside + 1] == pytest.approx(np.zeros(14), abs=0.1)
    assert found[beside + 30, beside + 31] == pytest.approx(np.full(14, 0.875), abs=0.1)
    assert np.linalg.eigvalsh(found).min() > 0.0


def test_forty_runs_show_how_small_a_loop_keeps_slow_changes():
    # Differences of white noise: their sum over a run is no more than one of them. Two channels,
    # the second what the first was before.
    rng = np.random.default_rng(6)
    white = rng.standard_normal((40, 101))
    one = np.diff(white)
    deviations = np.hstack([one, np.pad(one, ((0, 0), (1, 0)))[:, :-1]])
    found = covariance(deviations, 2)
    slow = np.cos(np.pi * (np.arange(100) + 0.5) / 50.0) / np.sqrt(50.0)
    found_value, usual = slow @ found[:100, :100] @ slow, 2.0
    assert found_value < 0.05 * usual  # 0.001 if it were known; a taper of 0.6 s leaves 0.3
    assert np.diag(found) == pytest.approx(np.full(200, usual), rel=0.4, abs=0.1)
    assert found[10:90, 111:191].diagonal() == pytest.approx(np.full(80, usual), rel=0.4)


def test_a_phase_and_its_opposite_are_tried_by_one_mark():
    ripple = effects()["torque_ripple"]
    (quarter,) = [each for each in shapes(ripple) if list(each.values()) == [3.0, np.pi / 2.0]]
    (same, as_is), (opposite, turned) = _twins(ripple, quarter)
    assert (same, as_is, turned) == (quarter, 1.0, -1.0)
    assert opposite["torque_ripple.phase"] == pytest.approx(1.5 * np.pi)
    kernel = plain(ripple.terms[0].kernel)
    signatures = [kernel(0.7, 1e-3, *each.values()) for each in (quarter, opposite)]
    assert signatures[1] == pytest.approx(-signatures[0], rel=1e-12)


def test_what_is_too_faint_to_name_is_unknown():
    entries = [e for e in recordings(3) if e.role != "show"]
    empty = search_effects(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    for delta_chi2, kind in (
        (VERDICT.doubt - 0.1, "recalibrated"),
        (VERDICT.doubt, "unknown"),
        (SEARCH.name_limit, "named"),
    ):
        trial = Trial(("hardening",), empty.baseline, delta_chi2)
        decision = decide(replace(empty, trials=[trial]), [0b011] * 2, [0b100] * 2)
        assert decision.kind == kind
        assert (f"where a name needs {SEARCH.name_limit:.0f}" in decision.reason) == (
            kind == "unknown"
        )
    for delta_chi2, kind in (
        (VERDICT.generic_limit - 0.1, "recalibrated"),
        (VERDICT.generic_limit, "unknown"),
    ):
        rival = Trial(("any_torque",), empty.baseline, delta_chi2)
        decision = decide(replace(empty, trials=[], generic=rival), [0b011] * 2, [0b100] * 2)
        assert decision.kind == kind
        assert decision.reason.startswith("a torque over") == (kind == "unknown")


def test_a_guess_that_goes_too_far_is_begun_at_a_share():
    entries = [e for e in recordings(3, ((HARDENING, 900.0),)) if e.role != "show"]
    found = search_effects(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    baseline, (guess,) = found.baseline, [g for g in found.guesses if g.effect == "hardening"]
    far = replace(guess, x=20.0 * guess.x)
    whole, part = started_at(baseline, far.places, far.x), started_at_guess(baseline, far)
    assert part.chi2 < 0.5 * whole.chi2
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


def test_a_plant_with_nothing_uncertain_takes_no_scatter():
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
        for recorded, others in confusable(effect).items():
            assert list(others.values()) == sorted(others.values(), reverse=True)
            for other, cosine in others.items():
                assert 0.0 < cosine <= 1.0
                assert confusable(other)[recorded][effect] == pytest.approx(cosine, abs=2e-3)
    assert "capstan" in text("gear_load")
    assert text("nobody_knows").endswith("is not yet measured")
