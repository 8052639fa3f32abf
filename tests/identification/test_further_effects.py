"""Several effects at once: found, pruned, and separated from what could stand in for them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from sled import (
    STIFFER,
    THREE,
    TURBULENCE,
    TWIN,
    WITH_GUST,
    Sled,
    campaign,
    found,
    recordings,
    three_found,
)

from hannes.commands.diagnose import diagnose
from hannes.identification.diagnosis import decision as decision_module
from hannes.identification.diagnosis import (
    each_explains,
    effect_removal,
    effect_search,
    forward_selection,
    further_effects,
    sets_as_given,
)
from hannes.identification.diagnosis.decision import Decision, _best_alone, _some_of, _surely_missed
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.gauss_newton import wald
from hannes.identification.diagnosis.joint_starts import entering, lasso_path, started_together
from hannes.identification.diagnosis.score_test import in_place_of, screened, screened_widely
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.trials import Joint, Trial, joint_rivals
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded

FAINT = np.full(10, 0.5)  # noise floors


@pytest.fixture(scope="module")
def three():
    """What a search finds of three hidden effects."""
    return three_found()


def test_three_effects_are_all_named_and_each_explains_something(tmp_path):
    said = diagnose(campaign(3, THREE, WITH_GUST), out=tmp_path / "out", progress=False).verdict
    assert said.verdict == "named" and sorted(said.effects) == ["gust", "hardening", "turbulence"]
    for effect, size in THREE:
        assert said.parameters[f"{effect.name}.size"]["value"] == pytest.approx(size, rel=0.05)
    assert set(said.each_explains) == set(said.effects)
    for each in said.each_explains.values():
        assert 0.005 < each["explains"] <= 1.0
        assert each["without"]["speed"] > 1.2 * said.gap["speed"]["after"]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "What each effect explains" in page and "1e+02" not in page


def test_a_single_effect_has_no_table_of_what_each_explains():
    assert found(1, ((TURBULENCE, 2.0),)).each_explains == {}


def test_where_nothing_shows_no_effect_explains_all_of_it(three, monkeypatch):
    """Below the noise floor before and after: what is lost without one is a share of nothing."""
    stages = SimpleNamespace(
        segments=[SimpleNamespace(role="show")], noise_floors={"speed": 1.0},
        points=(None, None, three.joint.trial.point), raw=lambda stage, role: [{"speed": FAINT}],
    )  # fmt: skip
    monkeypatch.setattr(each_explains, "_left", lambda *given: [[{"speed": 1.1 * FAINT}]] * 3)
    effects = three.joint.trial.effects
    decision = Decision("named", effects, "", three.joint.trial.point)
    made = each_explains.each_explains(stages, decision, 1.0, {name: name for name in effects})
    assert [each["explains"] for each in made.values()] == [0.0, 0.0, 0.0]


def test_no_further_effect_is_added_where_two_are_all(three, monkeypatch):
    """With room for it: what is left of three is less than a name needs."""
    assert len(three.joint.trial.effects) == 3
    assert three.remaining is None
    entries = [e for e in recordings(3, THREE[:2]) if e.role != "show"]
    two = search_effects(Sled(), entries, list(WITH_GUST.values()), Settings(0.02, 0.005), 0)
    assert sorted(two.joint.trial.effects) == ["hardening", "turbulence"]
    assert two.remaining.effect == "gust"
    assert two.remaining.delta_chi2 < SEARCH.name_limit * two.variance_factor


def test_no_more_effects_are_named_together_than_allowed(monkeypatch):
    two = replace(SEARCH, most_effects=2, biased_baseline=np.inf)
    for module in (forward_selection, sets_as_given):
        monkeypatch.setattr(module, "SEARCH", two)
    monkeypatch.setattr(effect_search, "SEARCH", SEARCH)
    entries = [e for e in recordings(3, THREE) if e.role != "show"]
    some = search_effects(Sled(), entries, list(WITH_GUST.values()), Settings(0.02, 0.005), 0)
    assert len(some.joint.trial.effects) == 2
    assert some.remaining.delta_chi2 > SEARCH.name_limit * some.variance_factor


def test_what_a_set_of_others_lacks_is_left_out_in_one_order(three, monkeypatch):
    """Also in the next process: sets of names have another order in each."""
    joint, asked = replace(three.joint, replaceable={}), []
    other = replace(joint.trial, effects=("another", "and", "more"))
    monkeypatch.setattr(effect_removal, "screened", lambda point, names: [])
    monkeypatch.setattr(effect_removal, "joint_rivals", lambda joint: [other])
    monkeypatch.setattr(
        effect_removal, "_known_without", lambda found, joint, name, _: asked.append(name) or joint
    )
    effect_removal.with_rivals(replace(three, joint=joint), lambda text: None)
    assert asked == list(joint.trial.effects)


def test_a_set_that_leaves_less_takes_the_place_of_the_joint_one(three, monkeypatch):
    joint, silent = three.joint, lambda text: None
    worse = replace(joint.trial, delta_chi2=joint.trial.delta_chi2 - 40.0)
    other = replace(joint, trial=worse, losses={}, without={}, others=(joint.trial,))
    monkeypatch.setattr(effect_removal, "screened", lambda point, names: [])
    said = effect_removal.with_rivals(replace(three, joint=other), silent).joint
    assert said.trial.effects == joint.trial.effects
    assert said.trial.delta_chi2 == joint.trial.delta_chi2
    assert [each.delta_chi2 for each in said.others] == [worse.delta_chi2]
    assert said.losses


def test_a_lasso_path_without_correlation_is_soft_thresholding():
    gradient, curvature = np.array([3.0, -2.0, 0.5]), np.array([1.0, 4.0, 0.25])
    low, high = np.full(3, -10.0), np.array([10.0, 10.0, 0.3])
    scale = np.sqrt(curvature)
    shares = np.geomspace(1.0, SEARCH.least_penalty, SEARCH.penalties)
    path = list(lasso_path(gradient, np.diag(curvature), low, high))
    assert len(path) == SEARCH.penalties
    for share, x in zip(shares, path, strict=True):
        penalty = share * np.max(np.abs(gradient) / scale) * scale
        least = np.sign(gradient) * np.maximum(np.abs(gradient) - penalty, 0.0) / curvature
        assert x == pytest.approx(np.clip(least, low, high), abs=1e-12)


def test_a_lasso_path_meets_its_conditions_of_optimality():
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((6, 40))
    rows[1] = rows[0] + 0.3 * rng.standard_normal(40)  # two that are much alike
    hessian, gradient = rows @ rows.T, rows @ (2.0 * rows[0] - rows[3] + rng.standard_normal(40))
    low, high = np.full(6, -0.8), np.full(6, 1.5)
    scale = np.sqrt(np.diag(hessian))
    path = list(lasso_path(gradient, hessian, low, high))
    assert not path[0].any()
    shares = np.geomspace(1.0, SEARCH.least_penalty, SEARCH.penalties)
    for share, x in zip(shares, path, strict=True):
        penalty = share * np.max(np.abs(gradient) / scale)
        slope = (gradient - hessian @ x) / scale / penalty
        inner = (low < x) & (x < high)
        assert np.all(np.abs(slope[inner & (x == 0.0)]) < 1.0 + 0.02)
        assert slope[inner & (x != 0.0)] == pytest.approx(np.sign(x[inner & (x != 0.0)]), abs=0.02)
        assert np.all(slope[x == high] > 1.0 - 0.02) and np.all(slope[x == low] < -1.0 + 0.02)


def test_what_is_missing_enters_first_and_is_started_together(three):
    guesses = screened_widely(three.baseline, list(WITH_GUST))
    assert {each.effect for each in entering(three.baseline, guesses)} == set(WITH_GUST)
    starts = list(started_together([(three.baseline, guesses)], lambda text: None))
    assert 1 <= len(starts) <= SEARCH.joint_starts
    best = {frozenset(names): point for names, point in starts}
    assert best[frozenset(WITH_GUST)].chi2 == pytest.approx(three.joint.trial.point.chi2, abs=2.0)
    assert entering(three.baseline, []) == []


def test_effects_started_together_are_found_where_the_best_single_one_leads_nowhere(monkeypatch):
    """Selection stops at once: nothing is found beside the first one."""
    enlarged = forward_selection._enlarged
    monkeypatch.setattr(
        forward_selection,
        "_enlarged",
        lambda found, best, *rest: enlarged(found, best, *rest) if len(best.effects) > 1 else [],
    )
    entries = [e for e in recordings(3, THREE) if e.role != "show"]
    some = search_effects(Sled(), entries, list(WITH_GUST.values()), Settings(0.02, 0.005), 0)
    assert sorted(some.joint.trial.effects) == ["gust", "hardening", "turbulence"]


def test_where_one_does_not_stay_beside_what_leaves_much_the_next_is_tried(three, monkeypatch):
    """The one that promises most does not stay at first, as one that held-out runs refuse."""
    alone, asked, pruned = Joint(three.trials[0]), [], forward_selection.pruned_effects

    def without_the_first(found, joint, progress):
        asked.append(joint.trial.effects[-1])
        return alone if len(asked) == 1 else pruned(found, joint, progress)

    monkeypatch.setattr(forward_selection, "pruned_effects", without_the_first)
    some = forward_selection.selected(replace(three, joint=None), alone, lambda text: None)
    assert some.joint is not None and len(set(asked[:2])) == 2
    assert sorted(some.joint.trial.effects) == sorted(WITH_GUST)


def ended(*_):
    raise SearchEnded


def test_where_the_bound_ends_the_search_what_was_found_by_then_stands(three, monkeypatch):
    """With a remainder, and with some work of its own for what could stand in for it."""
    others, calls = forward_selection._others, []

    def ended_at_the_third(found, best):
        calls.append(best)
        return others(found, best) if len(calls) < 3 else ended()

    monkeypatch.setattr(forward_selection, "_others", ended_at_the_third)
    limit = three.baseline.model.work.limit
    some = further_effects.with_further_effects(replace(three, joint=None), 0, lambda text: None)
    assert some.cut_short and some.baseline.model.work.limit > limit
    assert len(some.joint.trial.effects) == 3 and some.joint.losses  # the third was complete


def test_where_the_bound_is_met_by_what_could_stand_in_that_is_tried_once_more(three, monkeypatch):
    rivals, calls = further_effects.with_rivals, []

    def ended_at_first(found, progress):
        calls.append(found.cut_short)
        return rivals(found, progress) if len(calls) > 1 else ended()

    monkeypatch.setattr(further_effects, "with_rivals", ended_at_first)
    some = further_effects.with_further_effects(replace(three, joint=None), 0, lambda text: None)
    assert calls == [False, True] and some.cut_short
    assert len(some.joint.trial.effects) == 3
    monkeypatch.setattr(further_effects, "with_rivals", ended)
    with pytest.raises(SearchEnded):  # what could stand in for them is not known
        further_effects.with_further_effects(replace(three, joint=None), 0, lambda text: None)


def test_a_search_that_comes_back_to_where_it_was_ends(three, monkeypatch):
    """Two minima that lead to each other: what is added drops what was there, and back again."""
    one, refused, other = WITH_GUST
    alone = Joint(replace(three.trials[0], effects=(one,)))
    order = {(one,): (refused, other), (other,): (refused, one)}
    steps = []

    def others(found, best):
        return [SimpleNamespace(effect=name) for name in order[best.effects]]

    def enlarged(found, best, guesses, progress):
        steps.append((best.effects, guesses[0].effect))
        assert len(steps) < 20, "without an end"
        return [replace(best, effects=(*best.effects, guesses[0].effect),
                        delta_chi2=2.0 * best.delta_chi2)]  # fmt: skip

    def pruned(found, best, larger, progress):
        name = larger[0].effects[-1]
        return Joint(best if name == refused else replace(best, effects=(name,)))

    for name, made in (("_others", others), ("_enlarged", enlarged), ("_pruned", pruned)):
        monkeypatch.setattr(forward_selection, name, made)
    monkeypatch.setattr(forward_selection, "leaves_much", lambda found, trial: True)
    monkeypatch.setattr(forward_selection, "converged", lambda baseline, trial, _: trial)
    forward_selection.selected(replace(three, joint=None), alone, lambda text: None)
    assert ((one,), other) in steps and ((other,), one) in steps


def test_what_is_lost_without_an_effect_is_as_the_linearisation_says(three):
    joint = three.joint
    point, space = joint.trial.point, joint.trial.point.space
    for name in joint.trial.effects:
        predicted = wald(point, [space.place(f"{name}.size")])
        row = int(np.searchsorted(point.active, space.place(f"{name}.size")))
        guess = replace(screened(point, [name])[0], signature=point.jacobian[[row]])
        in_place = in_place_of(point, name, [guess])[name].delta_chi2
        assert in_place == pytest.approx(predicted, rel=0.02)  # an effect stands in for itself
        assert joint.losses[name] > SEARCH.name_limit
    assert wald(point, [0]) == pytest.approx(
        point.x[0] ** 2 / np.linalg.inv(point.hessian)[0, 0], rel=1e-3
    )


def test_an_effect_with_a_twin_is_not_named_beside_others():
    """The other two are, where they explain enough; the twins are not separated."""
    known = {**WITH_GUST, "twin": TWIN}
    entries = [e for e in recordings(3, THREE) if e.role != "show"]
    some = search_effects(Sled(), entries, list(known.values()), Settings(0.02, 0.005), 0)
    rivals = joint_rivals(some.joint)
    assert [set(each.effects) ^ set(some.joint.trial.effects) for each in rivals] == [
        {"turbulence", "twin"}
    ]


def _joint(point=None, **losses):
    names = tuple(losses)
    return Joint(
        Trial(names, point, 1000.0),
        {n: Trial(tuple(m for m in names if m != n), None, 1000.0 - losses[n]) for n in names},
        losses,
    )


def test_rivals_are_weighed_by_what_those_effects_explain_in_which_they_differ(three):
    joint, point = _joint(a=700.0, b=60.0), three.baseline
    joint = replace(joint, trial=replace(joint.trial, point=point))
    sets = {("a", "c"): 985.0, ("d", "b"): 950.0, ("a", "e"): 991.0}
    others = tuple(Trial(names, point, delta_chi2) for names, delta_chi2 in sets.items())
    joint = replace(joint, others=others)
    found = [each.effects for each in joint_rivals(joint)]
    assert found == [("d", "b"), ("a", "e")]  # 50 of 700 and 9 of 60, not 15 of 60
    nothing_left = replace(joint, trial=replace(joint.trial, point=three.joint.trial.point))
    assert [each.effects for each in joint_rivals(nothing_left)] == [("a", "e")]


@pytest.mark.parametrize(
    ("explained", "kind", "effects"),
    [
        (0.99, "named_with_remainder", ("a", "b", "c")),  # 10 are left
        (0.95, "named_with_remainder", ("a", "b")),  # 53 are left: 60 may belong to that
        (0.85, "unknown", ()),  # 176 are left: b and c may belong to that
    ],
)
def test_what_explains_not_much_more_than_what_is_left_is_not_named(
    three, explained, kind, effects
):
    joint = _joint(three.baseline, a=800.0, b=300.0, c=60.0)
    decision = _surely_missed(replace(three, trials=[]), joint, explained, "reason")
    assert (decision.kind, decision.effects) == (kind, effects)


@pytest.mark.parametrize(("share", "kind"), [(0.93, "named_with_remainder"), (0.7, "unknown")])
def test_where_several_do_not_stand_together_the_best_may_alone(three, monkeypatch, share, kind):
    joint, alone = _joint(a=800.0, b=300.0), Trial(("a",), three.trials[0].point, 1000.0)
    monkeypatch.setattr(decision_module, "explained_share", lambda *_: share)
    monkeypatch.setattr(decision_module, "doubt_about", lambda *_: "")
    for trials in ([alone], [replace(alone, effects=("c",))]):
        some = replace(three, trials=trials, joint=joint)
        said = _best_alone(some, joint.trial, "reason")
        stands = kind != "unknown" and trials == [alone]
        assert said.kind == (kind if stands else "unknown")
        assert said.effects == (("a",) if stands else ())


def test_what_a_generic_disturbance_may_do_too_is_not_named(three):
    joint = replace(_joint(a=800.0, b=300.0, c=60.0), replaceable={"c": "any_torque"})
    decision = _some_of(three, joint, {"a", "b"}, "reason")
    assert (decision.kind, decision.effects) == ("named_with_remainder", ("a", "b"))
    assert _some_of(replace(three, trials=[]), joint, {"c"}, "reason").kind == "unknown"


def test_large_effects_are_tried_to_the_end_of_their_range(three):
    sizes = np.abs(SEARCH.screening_sizes)
    assert {1.0, 2.0, 4.0, 8.0, 16.0} <= set(sizes) and sizes.max() > 55.0
    wide = {each.effect: each for each in screened_widely(three.nominal, list(WITH_GUST))}
    small = {each.effect: each for each in screened(three.nominal, list(WITH_GUST))}
    assert all(wide[name].delta_chi2 >= small[name].delta_chi2 for name in WITH_GUST)
    assert STIFFER.name not in wide
