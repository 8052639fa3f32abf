"""Decisions: what is named, and what speaks against it."""

from dataclasses import replace

import numpy as np
import pytest
from sled import KNOWN, NARROW, TURBULENCE, Sled, found, recordings

from hannes.identification.diagnosis import decision as choices
from hannes.identification.diagnosis import reservations
from hannes.identification.diagnosis.decision import _several, decide
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.heldout import heldout_reduction, runs_in_role
from hannes.identification.diagnosis.prior_distance import prior_distance
from hannes.identification.diagnosis.reservations import _at_end, explained_share
from hannes.identification.diagnosis.residual_tests import StructuredResidual
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.trials import Joint, Trial
from hannes.identification.diagnosis.tuning import SEARCH, VERDICT
from hannes.simulation.catalogue import effects


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


def test_a_gain_is_of_what_was_not_fitted_too(investigated):
    baseline, best = investigated.baseline, investigated.trials[0].point
    fitted_runs, heldout_runs = ([0b011] * 2, [0b100] * 2)
    assert heldout_reduction(baseline, best, fitted_runs, heldout_runs) > SEARCH.name_limit
    assert heldout_reduction(baseline, baseline, fitted_runs, heldout_runs) == 0.0
    assert heldout_reduction(baseline, best, fitted_runs, [0, 0]) == 0.0


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


@pytest.mark.parametrize(("other", "kind"), [("", "one_of"), ("more is left", "unknown")])
def test_a_class_stands_where_only_further_effects_were_not_searched_to_the_end(
    investigated, monkeypatch, other, kind
):
    best = investigated.trials[0]
    rival = replace(best, effects=("hardening",), delta_chi2=best.delta_chi2 - 1.0)
    found = replace(investigated, trials=[best, rival], joint=None, cut_short=True)
    monkeypatch.setattr(
        choices,
        "something_more",
        lambda found, trial: other or ("ended" if found.cut_short else ""),
    )
    monkeypatch.setattr(choices, "explained_share", lambda *given: 1.0)
    masks = (runs_in_role(found.baseline.model.groups, role) for role in ("fit", "select"))
    assert decide(found, *masks).kind == kind


def test_several_effects_are_named_whatever_single_ones_do(investigated):
    """In the noise of the machine with all of them, none may lower the misfit by itself."""
    joint = Joint(replace(investigated.trials[0], effects=("turbulence", "hardening")))
    masks = [runs_in_role(investigated.baseline.model.groups, r) for r in ("fit", "select")]
    found = decide(replace(investigated, trials=[], joint=joint), *masks)
    assert found.effects == ("turbulence", "hardening")
