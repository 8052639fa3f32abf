"""Rows that were simulated are kept: a fit tries a step, and then goes there."""

from types import SimpleNamespace

import numpy as np

from hannes.identification.diagnosis.known_vectors import MOST, KnownVectors

GROUP, OTHER = (SimpleNamespace(part=np.zeros(2)) for _ in range(2))


def made_of(calls):
    """What stands for the simulation; notes how many rows it was asked for."""

    def made(rows):
        calls.append(len(rows))
        return np.column_stack([rows.sum(axis=1), rows.prod(axis=1)])

    return made


def test_a_row_is_simulated_once_for_each_group_and_model():
    calls, known = [], KnownVectors()
    rows = np.array([[1.0, 2.0], [3.0, 4.0], [1.0, 2.0]])
    first = known.of(GROUP, True, rows[:2], made_of(calls))
    again = known.of(GROUP, True, rows[1:], made_of(calls))
    assert calls == [2] and first.tolist() == [[3.0, 2.0], [7.0, 12.0]]
    assert again.tolist() == [[7.0, 12.0], [3.0, 2.0]]
    known.of(OTHER, True, rows[:1], made_of(calls))
    known.of(GROUP, False, rows[:1], made_of(calls))
    assert calls == [2, 1, 1]


def test_a_run_that_fails_is_kept_as_well_and_only_the_latest_are():
    calls, known = [], KnownVectors()
    lost = known.of(GROUP, True, np.full((1, 2), np.nan), made_of(calls))
    assert np.isnan(lost).all() and np.isnan(known.of(GROUP, True, lost, made_of(calls))).all()
    assert calls == [1]
    many = np.arange(2.0 * MOST + 2.0).reshape(-1, 2)
    assert known.of(GROUP, True, many, made_of(calls)).shape == (MOST + 1, 2)
    known.of(GROUP, True, np.full((1, 2), np.nan), made_of(calls))
    assert calls == [1, MOST + 1, 1]
