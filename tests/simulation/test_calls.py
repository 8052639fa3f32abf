"""Calls within whole grasps: few words each, no counting of references; and what counts them."""

import numpy as np
import pytest

from benchmarks.calls import MOST, calls, pushes
from hannes.core.layout import Layout, Slot
from hannes.simulation.compiler import module_cache
from hannes.simulation.compiler.assemble import Equations, assemble
from tests import mass_on_spring


def layout(*names):
    return Layout(tuple(Slot(name, "1", "of the test") for name in names))


def ran(times):
    """The entry `grasps` of a mass on a spring, compiled anew, and its states at `times`."""
    model = assemble(
        Equations(
            mass_on_spring,
            layout("stiffness", "level"),
            layout("place", "speed"),
            layout("push"),
            layout("force"),
            memory=1,
        )
    )
    rows, memories = np.zeros((times.size, 2)), np.zeros((times.size, 1))
    kept, counts = np.zeros((1, 1, times.size)), np.zeros((1, 6), np.int64)
    model.fast.grasps(
        *(np.array([[3.0, 100.0]]), np.array([[1.0, 0.0]]), np.array([[0.0, 1.0], [0.0, 2.0]])),
        *(times[-1:], np.zeros(1), times, np.zeros(1, np.int64), model.needed.by([0])),
        *(1e-4, np.full(2, 1e-7), np.zeros(1, np.bool_), False, rows, memories, kept, counts),
    )
    assert counts[0, 4] == 0
    return model.fast.grasps, rows


@pytest.mark.usefixtures("compiling")
def test_no_call_within_a_grasp_hands_on_more_than_16_words(tmp_path, monkeypatch):
    times = np.linspace(0.0, 1.0, 11)
    monkeypatch.setenv("HANNES_CACHE", str(tmp_path / "by address"))
    made, rows = ran(times)
    found = calls(made)
    assert found
    assert max(call.words for call in found) <= MOST
    assert pushes(made) <= MOST
    assert not [call for call in found if call.counts_references]
    # Arrays handed on as they are would be seen, and give the same numbers.
    monkeypatch.setenv("HANNES_CACHE", str(tmp_path / "as they are"))
    monkeypatch.setattr(module_cache, "by_address", lambda text: text)
    bare, same = ran(times)
    assert max(call.words for call in calls(bare)) > MOST
    assert rows.tobytes() == same.tobytes()
