"""The tables of tuning constants: complete, and frozen."""

from dataclasses import FrozenInstanceError, fields

import pytest

from hannes.identification import tunings


def test_every_constant_stands_in_a_table_with_unit_meaning_and_origin():
    text = tunings.tables()
    for method in tunings.METHODS.values():
        for each in method:
            for constant in fields(each):
                name = f"`{type(each).__name__}.{constant.name}`"
                (row,) = [line for line in text.splitlines() if name in line]
                cells = [cell.strip() for cell in row.strip("|").split("|")]
                assert len(cells) == 5 and all(cells), row


def test_constants_cannot_be_changed_in_place():
    with pytest.raises(FrozenInstanceError):
        tunings.SEARCH.name_limit = 1.0
