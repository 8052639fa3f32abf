"""Faults of one finger in the independent truth: the same runs as the library's own values give."""

import numpy as np
import pytest

from benchmarks.truth.faults import RANGES, Fault, broken
from benchmarks.truth.parameters import FINGERS, NOMINAL, named
from hannes.plants.hand.finger_faults import FAULTS


def own_values(fault):
    """The library's values of that finger, by the fault of the same name."""
    effect = FAULTS[f"{fault.finger}_{fault.kind}"]
    (amplitude,) = (each for each in effect.amplitudes if each.name.startswith(fault.joint))
    moves = effect.moves[amplitude.name]
    shared = {f"{fault.finger}.end_{fault.joint}": NOMINAL[f"fingers.{fault.joint}_upper"]}
    place = FINGERS.index(fault.finger)
    base = {name: row[place] for name, row in shared.items()}
    return {name: base.get(name, 1.0) + change * fault.size for name, change in moves.items()}


@pytest.mark.parametrize("kind", RANGES)
@pytest.mark.parametrize("joint", ["mcp", "pip"])
def test_a_fault_is_the_same_in_both(kind, joint):
    fault = Fault(kind, "ring", joint, RANGES[kind][0])
    mine, theirs = named(own_values(fault)), broken(NOMINAL, fault)
    assert mine.keys() == theirs.keys()
    for name, value in theirs.items():
        assert np.allclose(mine[name], value, rtol=1e-12), name
    assert any(not np.array_equal(value, NOMINAL.get(name, 1.0)) for name, value in theirs.items())


def test_other_fingers_keep_their_values():
    whole = broken(NOMINAL, Fault("slipped_wire", "index", "pip", 0.4))
    assert whole["finger_share.pip_moment_arm"] == (0.6, 1.0, 1.0, 1.0, 1.0)
