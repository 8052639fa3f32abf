"""A clock under another name than time."""

import numpy as np
import pytest

from hannes.campaigns.begin.column_guess import Seen, guesses

RISING = np.arange(0.0, 2e9, 2e6)


@pytest.mark.parametrize(
    ("name", "values", "unit"),
    [
        ("header/ns", RISING, "ns"),
        ("tick_us", RISING % 65536.0, "us"),  # by its word, though it wraps
        ("loop_ms", np.full(1000, 2.0), None),  # a duration is no clock
        ("temperature_C", RISING, None),
    ],
)
def test_what_increases_in_a_unit_of_time_is_a_clock(name, values, unit):
    found = guesses([Seen(name, name, "", values)], ("position", "current", "reference"))
    assert [(each.channel, each.unit) for each in found] == ([("time", unit)] if unit else [])
