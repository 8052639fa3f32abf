"""Values that are farther from the given ones than machines differ."""

from types import SimpleNamespace

import pytest

from hannes.identification.calibration.far_value import far_values, without_far
from hannes.identification.calibration.identifiability import (
    CONFOUNDED,
    IDENTIFIED,
    NOT_IDENTIFIED,
    Answer,
)


def answer(name, value, label=IDENTIFIED, deviation=0.01, freedom=9.0, given=1.0):
    """Of a parameter, in ohm."""
    ends = (value - 2.0 * deviation, value + 2.0 * deviation)
    return Answer(name, "ohm", value, *ends, given, label, (), "", deviation, freedom, ends, False)


def plan(*names):
    """Given values are off by 0.03."""
    return SimpleNamespace(usual=dict.fromkeys(names, 0.03))


def test_a_far_value_counts_in_what_machines_and_estimates_differ_by():
    (found,) = far_values(plan("a", "b"), [answer("a", 1.05), answer("b", 0.79)])
    assert found.name == "b" and found.off == "-21 %"
    assert found.deviations == pytest.approx(-0.21 / (0.03**2 + 0.01**2) ** 0.5)
    assert "b ended -21 % from its given value, 6.6 times" in found.sentence


def test_what_machines_differ_by_is_nothing_to_mention():
    assert far_values(plan("a"), [answer("a", 1.08)]) == ()


@pytest.mark.parametrize("deviation", [0.2, float("nan")])
def test_an_uncertain_estimate_is_not_far(deviation):
    assert far_values(plan("a"), [answer("a", 1.4, deviation=deviation)]) == ()


def test_of_few_runs_more_is_asked():
    many = answer("a", 1.5, deviation=0.1, freedom=50.0)
    few = answer("a", 1.5, deviation=0.1, freedom=2.0)
    assert far_values(plan("a"), [many]) and not far_values(plan("a"), [few])


def test_where_nothing_is_said_of_given_values_none_is_far():
    assert far_values(plan(), [answer("a", 3.0)]) == ()


def test_chance_counts_all_that_were_asked_for():
    (few,) = far_values(plan("a"), [answer("a", 1.3)])
    (many,) = far_values(plan("a", "b"), [answer("a", 1.3), answer("b", 1.0)])
    assert many.p_value == pytest.approx(2.0 * few.p_value)


def test_every_far_value_is_doubted_and_no_other():
    given = [answer("a", 1.3), answer("b", 1.0), answer("c", 1.2, CONFOUNDED), answer("d", 2.5)]
    far = far_values(plan("a", "b", "c", "d"), given)
    assert [each.name for each in far] == ["d", "a", "c"] and far[0].off == "+150 %"
    made = without_far(given, far)
    assert [each.label for each in made] == [NOT_IDENTIFIED, IDENTIFIED, CONFOUNDED, NOT_IDENTIFIED]
    assert "farther" in made[0].reason


def test_where_nothing_was_given_the_difference_has_its_unit():
    (found,) = far_values(plan("a"), [answer("a", 0.5, given=0.0)])
    assert found.off == "+0.5 ohm"
