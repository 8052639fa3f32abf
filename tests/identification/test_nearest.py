"""What comes nearest to an unknown."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from hannes.identification.diagnosis import nearest as module
from hannes.identification.diagnosis.decision import Decision
from hannes.identification.diagnosis.nearest import nearest
from hannes.identification.diagnosis.trials import Joint, SearchResult, Trial

NAMES = {name: name for name in ("slack", "ripple", "sag", "lag")}
UNKNOWN = Decision("unknown", (), "none is believed", None)


def trial(name, delta_chi2):
    """One that leaves so much less than the baseline's 1100."""
    return Trial((name,), SimpleNamespace(chi2=1100.0 - delta_chi2), delta_chi2)


@pytest.fixture
def found(monkeypatch):
    reasons = {"slack": "at an end of its range", "ripple": ""}
    monkeypatch.setattr(module, "doubt_about", lambda _, each: reasons[each.effects[0]])
    monkeypatch.setattr(module, "something_more", lambda _, each: "much is left")
    baseline = SimpleNamespace(chi2=1100.0, residual=SimpleNamespace(size=100))
    trials = [trial("slack", 500.0), trial("ripple", 450.0), trial("sag", 60.0), trial("lag", 9.0)]
    return SearchResult(None, baseline, [], trials, None, None, 1.0)


def test_the_best_candidates_come_with_what_they_explain_and_why_not(found):
    rows = nearest(found, UNKNOWN, NAMES)
    assert [each["effects"] for each in rows] == [["slack"], ["ripple"], ["sag"]]
    assert [each["explains"] for each in rows] == pytest.approx([0.5, 0.45, 0.06])
    assert [each["why_not"] for each in rows] == [
        "at an end of its range", "much is left", "it explains much less than the first",
    ]  # fmt: skip


def test_one_that_lowers_the_misfit_too_little_is_not_near(found):
    assert nearest(replace(found, trials=[trial("lag", 9.0)]), UNKNOWN, NAMES) == []


def test_every_other_verdict_has_none(found):
    assert nearest(found, Decision("recalibrated", (), "", None), NAMES) == []


def test_a_single_one_is_not_judged_by_what_is_left_beside_several(found, monkeypatch):
    joint = replace(found.trials[0], effects=("slack", "sag"), delta_chi2=510.0)
    monkeypatch.setattr(module, "doubt_about", lambda _, each: "")
    monkeypatch.setattr(module, "something_more", lambda known, each: str(known.joint is None))
    rows = nearest(replace(found, joint=Joint(joint)), UNKNOWN, NAMES)
    assert [each["why_not"] for each in rows] == ["False", "True", "True"]
