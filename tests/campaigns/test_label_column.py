"""The column that numbers or names runs."""

import pytest

from hannes.campaigns.begin.column_guess import label_column


@pytest.mark.parametrize(
    ("name", "cells", "found"),
    [
        ("Versuch", ["V1"] * 6 + ["V2"] * 6, True),  # a word of another language
        ("Versuch", ["V1"] * 12, True),  # the beginning holds the first run alone
        ("set", ["A 1"] * 6 + ["A 2"] * 6, True),  # words with numbers, under any name
        ("state", ["on", "off"] * 6, False),
        ("state", ["on"] * 12, False),
        ("step", ["s1", "s2"] * 6, False),  # changes all the time
        ("trial", ["1", "2", "3", "4"] * 3, False),
    ],
)
def test_a_label_is_a_known_name_or_words_with_numbers_that_seldom_change(name, cells, found):
    rows = [(f"{k}", cell, "0.5") for k, cell in enumerate(cells)]
    assert label_column(("time", name, "position"), rows) == (name if found else "")
