"""A value that is farther from the given one than machines differ."""

from types import SimpleNamespace

import pytest

from hannes.identification.calibration.far_value import FarValue, far_value, without_far
from hannes.identification.calibration.identifiability import (
    CONFOUNDED,
    IDENTIFIED,
    NOT_IDENTIFIED,
    Answer,
)


def answer(name, value, label=IDENTIFIED, deviation=0.01):
    """Of a parameter whose given value is 1."""
    ends = (value - 2.0 * deviation, value + 2.0 * deviation)
    return Answer(name, "ohm", value, *ends, 1.0, label, (), "", deviation, 9.0, ends, False)


def plan(**usual):
    """Standard deviations of given values."""
    return SimpleNamespace(usual={name.replace("_", "."): size for name, size in usual.items()})


def test_the_farthest_value_counts_in_what_machines_and_estimates_differ_by():
    found = far_value(plan(a=0.03, b=0.03), [answer("a", 1.05), answer("b", 0.79)])
    assert found.name == "b" and found.share == pytest.approx(-0.21)
    assert found.deviations == pytest.approx(-0.21 / (0.03**2 + 0.01**2) ** 0.5)
    assert found.likely and "b ended -21 % from its given value" in found.sentence


def test_what_machines_differ_by_is_nothing_to_mention():
    found = far_value(plan(a=0.03), [answer("a", 1.08)])
    assert not found.likely and found.sentence == ""


def test_an_uncertain_estimate_is_not_far():
    assert not far_value(plan(a=0.03), [answer("a", 1.4, deviation=0.2)]).likely


def test_where_nothing_is_said_of_given_values_none_is_far():
    assert far_value(plan(), [answer("a", 3.0)]) == FarValue()


def test_chance_counts_all_that_were_asked_for():
    few = far_value(plan(a=0.03), [answer("a", 1.09)]).p_value
    many = far_value(plan(a=0.03, b=0.03), [answer("a", 1.09), answer("b", 1.0)]).p_value
    assert many == pytest.approx(2.0 * few)


def test_the_far_value_alone_is_without_far():
    given = [answer("a", 1.3), answer("b", 1.0), answer("c", 1.0, CONFOUNDED)]
    made = without_far(given, far_value(plan(a=0.03, b=0.03, c=0.03), given))
    assert [each.label for each in made] == [NOT_IDENTIFIED, IDENTIFIED, CONFOUNDED]
    assert "farther" in made[0].reason
    sound = [answer("a", 1.01)]
    assert without_far(sound, far_value(plan(a=0.03), sound)) == sound
