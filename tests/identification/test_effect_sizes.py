"""How large effects are: of a pair the one whose size may be zero is removed."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.dynamics.leader_slack import EFFECT as SLACK
from hannes.dynamics.wire_compliance import EFFECT as COMPLIANCE
from hannes.identification.diagnosis import effect_sizes as module
from hannes.identification.diagnosis.decision import Decision
from hannes.identification.diagnosis.effect_sizes import NORMAL, interval, may_be_zero, with_sizes
from hannes.identification.diagnosis.final_fit import FinalFit
from hannes.identification.diagnosis.parameter_space import FreeParameter
from hannes.identification.diagnosis.tuning import FIT

EFFECTS = {each.name: each for each in (SLACK, COMPLIANCE)}
PLACES = ("leader_slack.length", "wire_compliance.leader", "wire_compliance.follower")
PAIR = (SLACK.name, COMPLIANCE.name)
EDGE = (
    NORMAL * FIT.interval_widening
)  # standard deviations from off, where an interval just holds it


def point(*x):
    """A made-up fit at x, steps of which are hundredths."""
    parameters = [FreeParameter(n, "", 0.0, 0.01, 0.0, 1.0, effect=n.split(".")[0]) for n in PLACES]
    space = SimpleNamespace(effects=EFFECTS, place=PLACES.index, parameters=parameters)
    return SimpleNamespace(x=np.array(x), space=space)


@pytest.fixture
def fits(monkeypatch):
    """Stand-ins for what takes long; the spread of each place, by which effects are sized."""
    spread = dict.fromkeys(range(3), 1.0)
    asked = []

    def final_fit(at, effects, accuracy, seed, variance_factor):
        asked.append(tuple(effects))
        return FinalFit(at, spread)

    def faded(at, name):
        return SimpleNamespace(**vars(at) | {"without": name})

    monkeypatch.setattr(module, "final_fit", final_fit)
    monkeypatch.setattr(module, "faded", faded)
    return SimpleNamespace(spread=spread, asked=asked)


def outcome(at, kind="named", effects=PAIR, variance_factor=1.0):
    """What comes of a choice."""
    return with_sizes(Decision(kind, effects, "so", at), 0, variance_factor, lambda text: None)[0]


def test_two_effects_that_are_both_sure_stay(fits):
    decision = outcome(point(1.1 * EDGE, 0.0, 1.1 * EDGE))
    assert (decision.kind, decision.effects) == ("named", PAIR)
    assert fits.asked == [PAIR]


def test_one_whose_interval_holds_off_is_let_go_and_the_other_sized_without_it(fits):
    decision = outcome(point(1.1 * EDGE, 0.0, 0.9 * EDGE))
    assert (decision.kind, decision.effects) == ("named_with_remainder", (SLACK.name,))
    assert decision.point.without == COMPLIANCE.name
    assert fits.asked == [PAIR, (SLACK.name,)]
    assert "wire compliance may be zero" in decision.reason


@pytest.mark.parametrize(("edges", "zero"), [(0.9, True), (1.1, False)])
def test_of_one_effect_it_is_seen_whether_it_may_be_zero(fits, edges, zero):
    one = Decision("named", (SLACK.name,), "so", point(edges * EDGE, 0.0, 0.0))
    assert may_be_zero(one, fits.spread, 1.0) == zero
    assert not may_be_zero(Decision("unknown", (), "so", one.point), {}, 1.0)


def test_where_neither_is_sure_the_surer_one_stays(fits):
    assert outcome(point(0.5 * EDGE, 0.9 * EDGE, 0.0)).effects == (COMPLIANCE.name,)


def test_sizes_count_in_the_noise_that_is_there(fits):
    at = point(1.1 * EDGE, 1.5 * EDGE, 0.0)
    assert outcome(at).effects == PAIR
    assert outcome(at, variance_factor=1.5).effects == (COMPLIANCE.name,)


def test_sizes_held_at_off_do_not_count(fits):
    del fits.spread[2]
    assert outcome(point(1.1 * EDGE, 1.1 * EDGE, 0.0)).effects == PAIR


def test_single_effects_and_classes_are_left_alone(fits):
    near = point(0.5 * EDGE, 0.5 * EDGE, 0.0)
    assert outcome(near, "one_of").kind == "one_of"
    assert outcome(near, "named", (SLACK.name,)).kind == "named"


def test_where_one_cannot_be_let_go_both_stay(fits, monkeypatch):
    monkeypatch.setattr(module, "faded", lambda at, name: None)
    assert outcome(point(1.1 * EDGE, 0.0, 0.0)).effects == PAIR


def test_intervals_end_at_bounds():
    found = interval(point(2.0, 0.0, 99.0), 0, 1.0, 1.0)
    assert found == {"value": 0.02, "low": 0.0, "high": pytest.approx(0.02 + 0.01 * EDGE)}
    assert interval(point(2.0, 0.0, 99.0), 2, 1.0, 1.0)["high"] == 1.0
