"""Effects with a name in hands whose fingers differ: what the study draws of their frozen sizes."""

import math
from collections import Counter

import numpy as np
import pytest

from benchmarks.naming_study.apart import sizes
from benchmarks.naming_study.apart.draw import drawn
from benchmarks.naming_study.apart.kinds import KINDS, NAMED, first_seed
from benchmarks.naming_study.frozen import smallest
from benchmarks.oracle import APART
from benchmarks.truth.effects import CATALOGUE
from benchmarks.truth.hidden import SIZES


def seeds(name, chosen="quoted"):
    first = first_seed(NAMED[name], chosen)
    return range(first, first + NAMED[name].counts[chosen])


@pytest.mark.parametrize("name", [k.name for k in KINDS if k.what in ("single", "pair", "triple")])
def test_sizes_are_clear_and_within_the_range(name):
    kind = NAMED[name]
    for seed in seeds(name):
        hidden = drawn(kind, seed)
        assert len(hidden.effects) == {"single": 1, "pair": 2, "triple": 3}[kind.what]
        assert hidden == drawn(kind, seed)
        for amplitude, times in hidden.times.items():
            size, own = SIZES[amplitude], hidden.sizes[amplitude]
            assert times >= sizes.CLEAR * (1.0 - 1e-12)
            assert size.low * (1.0 - 1e-12) <= own <= size.high * (1.0 + 1e-12)
            shape = {k: v for k, v in hidden.sizes.items() if k not in hidden.times}
            us = [s.u for s in smallest(kind.protocol, APART)[amplitude]
                  if dict(s.shape).items() <= shape.items()]  # fmt: skip
            assert any(u and times == pytest.approx(abs(own) / u) for u in us)


@pytest.mark.parametrize("name", [k.name for k in KINDS if k.what == "single"])
def test_each_third_of_a_range_comes_up_as_often(name):
    kind, counts, names = NAMED[name], Counter(), Counter()
    ranges = sizes.named(kind.protocol)
    for seed in seeds(name):
        hidden = drawn(kind, seed)
        ((amplitude, _),) = hidden.times.items()
        names[amplitude] += 1
        (third,) = {
            min(int(3.0 * math.log(abs(hidden.sizes[amplitude]) / r.low) / math.log(r.high / r.low)
                    + 1e-9), 2)
            for r in ranges[amplitude]
            if dict(r.shape).items() <= hidden.sizes.items()
            and r.sign == np.sign(hidden.sizes[amplitude])
        }  # fmt: skip
        counts[third] += 1
    assert sorted(counts.values()) == [16, 17, 17]
    assert max(names.values()) - min(names.get(each, 0) for each in ranges) <= 1


def test_effects_and_settings_have_their_turn():
    for protocol in ("naive", "poor", "rich"):
        effects = {name.partition(".")[0] for name in sizes.named(protocol)}
        assert {"mounting", "firmware_gains", "guide_load", "warming_grease"} <= effects
        assert effects <= {e.__name__.rpartition(".")[2] for e in CATALOGUE} | {
            "mounting", "firmware_gains", "current_limit",
        }  # fmt: skip


def test_both_signs_come_up_where_both_occur():
    found = [
        drawn(NAMED[f"single, {p}"], s) for p in ("poor", "rich") for s in seeds("single, rich")
    ]
    both = [h.sizes[n] for h in found for n in h.times if SIZES[n].low < 0.0 < SIZES[n].high]
    assert min(both) < 0.0 < max(both)
