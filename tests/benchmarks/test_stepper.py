"""The stepper has the bits of `simulate` over the shipped experiments."""

import numpy as np
import pytest

from benchmarks import stepper
from hannes.core.errors import BadInput
from hannes.simulation.experiment import shipped

VARIANTS = stepper.variants()


@pytest.mark.parametrize("name", sorted(VARIANTS))
def test_a_tick_a_call_has_the_bits_of_simulate(name):
    assert stepper.differing(VARIANTS[name]) == 0


def test_all_experiments_are_compared_but_the_one_that_needs_no_simulation():
    assert set(shipped.names()) - set(VARIANTS) == {"friction-curve"}
    assert any(each.hand.effects for each in VARIANTS.values())


def test_a_shipped_file_that_broke_is_said(monkeypatch):
    def broken(name):
        raise BadInput(f"{name}: broken")

    monkeypatch.setattr(stepper, "load", broken)
    with pytest.raises(BadInput, match="broken"):
        stepper.variants()


def test_values_are_compared_by_their_bits():
    some = np.array([0.0, 1.0, np.nan])
    assert stepper.unlike(some, some.copy()) == 0
    assert stepper.unlike(some, np.array([-0.0, 1.0, np.nan])) == 1


def test_the_median_of_its_share_of_a_core_is_judged(monkeypatch):
    monkeypatch.setattr(stepper, "variants", lambda: {"void-closure": VARIANTS["void-closure"]})
    monkeypatch.setattr(stepper, "shares", lambda *_: [0.01, 0.06, 0.07])
    (row,), (_, bound) = stepper.measure(quick=True)
    assert (row["least"], row["share"]) == (0.01, 0.06)
    assert bound["value"] == 0.06 and not bound["holds"]


def test_its_share_of_a_core_is_measured():
    (share,) = stepper.shares(VARIANTS["void-closure"], 1)
    assert 0.0 < share < 1.0
