"""How probable each explanation is, given recordings."""

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest

from hannes.identification.diagnosis import probability as module
from hannes.identification.diagnosis.decision import Decision
from hannes.identification.diagnosis.probability import probabilities, tabled_probabilities
from hannes.identification.diagnosis.trials import Joint, SearchResult, Trial
from hannes.identification.diagnosis.tuning import PROBABILITY
from hannes.identification.probability_words import probability_sentence

NAMES = {f"other_{k}": f"other_{k}" for k in range(40)} | {
    name: name for name in ("slack", "ripple", "sag", "lag")
}
BINS = 400


def found(reductions, left=0.0, **more):
    """A search of single effects, best first, that leave so much above noise."""
    point = SimpleNamespace(chi2=BINS + left, residual=SimpleNamespace(size=BINS))
    most = max(reductions.values(), default=0.0)
    baseline = SimpleNamespace(chi2=point.chi2 + most, residual=point.residual)
    trials = [Trial((name,), point, each) for name, each in reductions.items()]
    return SearchResult(None, baseline, list(NAMES), trials, None, None, 1.0, **more)


def both(search, reduction):
    """The same search, with slack and sag together."""
    return replace(search, joint=Joint(Trial(("slack", "sag"), search.trials[0].point, reduction)))


def decided(kind, *effects):
    return Decision(kind, effects, "", None)


def answer(search, decision):
    return tabled_probabilities(search, decision, NAMES)["answer"]


@pytest.mark.parametrize("reductions", [{}, {"slack": 3.0}, {"slack": 900.0, "sag": 880.0}])
def test_they_sum_to_one(reductions):
    known = probabilities(found(reductions), decided("named", "slack"))
    assert sum(known.effects.values()) + known.something_else == pytest.approx(1.0)


def test_where_nothing_lowers_the_misfit_nothing_is_missing():
    assert answer(found({"slack": 1.0, "lag": 0.5}), decided("recalibrated")) > 0.9


def test_an_effect_that_explains_all_is_there():
    assert answer(found({"slack": 2000.0, "lag": 300.0}), decided("named", "slack")) > 0.9


def test_two_that_explain_alike_share_what_one_has():
    search = found({"slack": 2000.0, "lag": 2000.0})
    assert answer(search, decided("named", "slack")) == pytest.approx(0.5, abs=0.06)
    assert answer(search, decided("one_of", "slack", "lag")) > 0.9


def test_much_that_is_left_is_something_else():
    search = found({"slack": 2000.0}, left=1000.0)
    table = tabled_probabilities(search, decided("unknown"), NAMES)
    assert table["something_else"] == table["answer"] > 0.95


def test_an_explanation_that_is_not_believed_counts_for_less():
    search = found({"slack": 20.0})
    named = probabilities(search, decided("named", "slack")).effects[frozenset({"slack"})]
    refused = probabilities(search, decided("unknown")).effects[frozenset({"slack"})]
    assert refused < named


def test_a_verdict_that_nothing_is_missing_is_the_likelier_answer():
    table = tabled_probabilities(
        found({"slack": 13.9}), decided("recalibrated"), {"slack": "slack"}
    )
    assert table["answer"] == table["nothing"] == pytest.approx(PROBABILITY.least_nothing)
    assert sum(row["probability"] for row in table["effects"]) <= 1.0 - table["nothing"]
    sure = tabled_probabilities(found({"slack": 1.0}), decided("recalibrated"), NAMES)
    assert sure["answer"] > 0.9


def test_an_unknown_that_no_likelihood_speaks_for_leaves_something_else_a_part():
    """What stands out in one place is in no sum over all bins: nothing is not certain then."""
    search = found({"slack": 1.0})
    table = tabled_probabilities(search, decided("unknown"), NAMES)
    assert table["something_else"] == pytest.approx(PROBABILITY.least_else)
    rest = sum(each["probability"] for each in table["effects"])
    assert table["nothing"] + table["something_else"] + rest == pytest.approx(1.0, abs=0.01)


def test_effects_with_a_remainder_are_there_where_they_explain_nearly_all(monkeypatch):
    search = found({"slack": 2000.0}, left=300.0)
    answers = []
    for share in (0.82, 0.97):
        monkeypatch.setattr(module, "explained_share", lambda *_, share=share: share)
        answers.append(answer(search, decided("named_with_remainder", "slack")))
    assert answers[0] < 0.4 < 0.7 < answers[1]


def test_several_effects_need_more_than_one_alone():
    pair = frozenset({"slack", "sag"})
    likely = [
        probabilities(both(found({"slack": 100.0}), each), decided("named")).effects[pair]
        for each in (104.0, 1000.0)
    ]
    assert likely[0] < 0.1 < 0.9 < likely[1]


def test_where_several_leave_noise_one_that_leaves_much_is_not_the_likelier():
    """It explains nine tenths, and fewer are to expect; but no law is wrong by what it leaves."""
    search = replace(found({"slack": 90_000.0}), joint=Joint(
        Trial(("slack", "sag"), found({}).baseline, 100_000.0), losses={"slack": 9e4, "sag": 9e4}
    ))  # fmt: skip
    assert answer(search, decided("named", "slack", "sag")) > 0.9


def test_a_search_that_was_ended_has_none():
    assert tabled_probabilities(found({}, ended="at its bound"), decided("unknown"), NAMES) == {}


def test_the_sentence_says_what_else_may_be():
    table = {
        "answer": 0.93, "nothing": 0.0, "something_else": 0.05,
        "effects": [{"effects": ["slack"], "probability": 0.93},
                    {"effects": ["gear_lag"], "probability": 0.02}],
    }  # fmt: skip
    assert probability_sentence(table, "named", ["slack"]) == (
        "Probability that this is what is missing: 93 %. "
        "Else: something in no catalogue 5 %, gear lag 2 %."
    )
    assert probability_sentence({}, "unknown", []) == ""


def test_of_a_class_each_has_its_own_probability():
    rows = {"slack": 0.61, "gear_lag": 0.35}
    table = {
        "answer": 0.96, "nothing": 0.0, "something_else": 0.0,
        "effects": [{"effects": [name], "probability": each} for name, each in rows.items()],
    }  # fmt: skip
    assert probability_sentence(table, "one_of", list(rows)) == (
        "Probability that it is one of these: 96 % (slack 61 %, gear lag 35 %)."
    )


def test_no_sentence_is_certain():
    table = {"answer": 1.0, "nothing": 1.0, "something_else": 0.0, "effects": []}
    assert probability_sentence(table, "no_gap", []).endswith("over 99 %.")


def test_the_probability_of_a_class_has_the_same_bits_in_any_order():
    """Names of a set have another order in each process, and sums of floats go by theirs."""
    names = [f"other_{k}" for k in range(12)]
    for k in range(1, 40):
        parts = {frozenset({name}): 1.0 / (7.0 + k * n) / 40.0 for n, name in enumerate(names)}
        known = module.Probabilities(parts, 0.0)
        said = module.of_answer(None, decided("one_of", *names), known)
        assert said == math.fsum(parts.values())
