"""A parameter that a user's file declares: what is no number is refused in one line."""

import pytest

from hannes import BadInput, Parameter


@pytest.mark.parametrize(
    "changed",
    [
        {"value": "1"},
        {"bounds": ("0", 2.0)},
        {"bounds": (0.0, 1.0, 2.0)},
        {"bounds": 2.0},
        {"off": "none"},
        {"tried": ("1",)},
        {"turns": True},
        {"value": None},
    ],
)
def test_what_is_no_number_is_refused(changed):
    given = {"name": "size", "value": 1.0, "unit": "N", "bounds": (0.0, 2.0), "doc": "", **changed}
    with pytest.raises(BadInput, match=r"^size"):
        Parameter(**given)
