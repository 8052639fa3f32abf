"""Calls within whole grasps: few words each, no counting of references; and what counts them."""

import math

import numba
import numpy as np
import pytest

from benchmarks.calls import MOST, calls, pushes
from hannes.core.kernels.jit import routine
from hannes.simulation.compiler import module_cache
from tests.assembled_spring import spring


def ran(times, by_numba=True):
    """Who runs a mass on a spring's `grasps`, compiled anew, and the states at `times`."""
    model = spring()
    rows, memories = np.zeros((times.size, 2)), np.zeros((times.size, 1))
    kept, counts = np.zeros((1, 1, times.size)), np.zeros((1, 6), np.int64)
    entry = model.fast.grasps
    grasps = entry.by_numba if by_numba else entry.single.entry(model.fast, entry.py_func)
    grasps(
        *(np.array([[3.0, 100.0]]), np.array([[1.0, 0.0]]), np.array([[0.0, 1.0], [0.0, 2.0]])),
        *(times[-1:], np.zeros(1), times, np.zeros(1, np.int64), model.needed.by([0])),
        *(
            1e-4,
            np.full(2, 1e-7),
            np.zeros(1, np.bool_),
            np.zeros(1),
            0,
            rows,
            memories,
            kept,
            counts,
        ),
    )
    assert counts[0, 4] == 0
    return grasps, rows


TIMES = np.linspace(0.0, 1.0, 11)


@pytest.fixture(scope="module")
def by_address(tmp_path_factory, compiling):
    """The same as the package compiles it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HANNES_CACHE", str(tmp_path_factory.mktemp("by address")))
        return ran(TIMES)


def test_no_call_within_a_grasp_hands_on_more_than_16_words(by_address):
    made, _ = by_address
    found = calls(made)
    assert found
    assert max(call.words for call in found) <= MOST
    assert pushes(made) <= MOST
    assert not [call for call in found if call.counts_references]


def test_long_functions_are_called_not_written_out_again(by_address):
    made, _ = by_address
    found = {(call.caller, call.callee) for call in calls(made)}
    assert found >= {("grasp", "advance"), ("advance", "equations"), ("first_step", "equations")}


def test_our_own_compiler_gives_the_same_bits(by_address, tmp_path, monkeypatch):
    monkeypatch.setenv("HANNES_CACHE", str(tmp_path))
    _, rows = ran(TIMES, by_numba=False)
    assert rows.tobytes() == by_address[1].tobytes()


@routine
def weighted(a, b, c, k):
    """Three arrays at once, and a number."""
    total = 0.0
    for j in range(a.size):
        for _ in range(k):
            total = math.sqrt(total + a[j] * b[j] + c[j])
    return total


def kept_a_call(a, b, c):
    """Called twice: so it stays a function."""
    return weighted(a, b, c, 3) + weighted(b, a, c, 4) + weighted(c, b, a, a.size)


@pytest.mark.usefixtures("compiling")
def test_arrays_handed_on_as_they_are_are_seen():
    made = numba.njit(kept_a_call)
    made(*np.ones((3, 4)))
    widest = max(calls(made), key=lambda call: call.words)
    assert (widest.caller, widest.callee) == ("kept_a_call", "weighted") and widest.words > MOST


@pytest.mark.slow
def test_a_grasp_with_arrays_handed_on_as_they_are_has_the_same_bits(
    by_address, tmp_path, monkeypatch
):
    monkeypatch.setenv("HANNES_CACHE", str(tmp_path))
    monkeypatch.setattr(module_cache, "by_address", lambda text: text)
    assert by_address[1].tobytes() == ran(TIMES)[1].tobytes()
