"""The stepper has the bits of `simulate` over the shipped experiments."""

import pytest

from benchmarks import stepper

VARIANTS = stepper.variants()


@pytest.mark.parametrize("name", sorted(VARIANTS))
def test_a_tick_a_call_has_the_bits_of_simulate(name):
    assert len(VARIANTS) >= 9
    assert stepper.differing(VARIANTS[name]) == 0


def test_its_share_of_a_core_is_measured():
    assert 0.0 < stepper.share(VARIANTS["void-closure"], 1) < 1.0
