"""What benchmarks share: tables, intervals, memory, and the page that `make bench` writes."""

import re

import numpy as np

from benchmarks.__main__ import FOLDER, NAMES, PAGE, RECORDED, page, recorded, with_records
from benchmarks.batch import columns, ratio, with_effects
from benchmarks.harness import aligned, interval, must_show, peak_mib, processor, table
from hannes.simulation.catalogue import effects
from hannes.simulation.hand.hand import Hand

ROWS = [{"what": "a", "ms": 1.5}, {"what": "b", "ms": 2.0, "more": "x"}]
BOUNDS = [
    must_show("ratio", 2.0, 1.8, True) | {"low": 1.9, "high": 2.1},
    must_show("memory", 2000.0, 1024, False),
]


def test_the_page_has_every_benchmark_its_bounds_and_rows():
    text = page({name: {"rows": aligned(ROWS), "must_show": BOUNDS} for name in NAMES})
    kept = [name for name in RECORDED if (FOLDER / "records" / f"{name}.json").exists()]
    headings = [line[3:] for line in text.splitlines() if line.startswith("## ")]
    assert headings == [*NAMES, *kept] and "kills" in kept
    assert text.count("| ratio | 2 | 1.9 to 2.1 | 1.8 | yes |") == len(NAMES)
    assert text.count("| memory | 2000 |  | 1024 | **no** |") == len(NAMES)
    assert re.search(r"\d+ cores", processor()) and processor() in text
    assert "/home" not in text and "/tmp" not in text


def test_the_page_says_of_long_runs_what_their_records_say():
    text = PAGE.read_text(encoding="utf-8")
    assert with_records(text) == text, "run `python -m benchmarks --records`"
    name = next(iter(recorded()))
    other = text.replace(f"\n## {name}\n", f"\n## {name}\n\nof before\n")
    assert other != text and with_records(other) == text


def test_rows_of_several_kinds_make_one_table():
    lines = table(aligned(ROWS)).splitlines()
    assert lines[0].split() == ["what", "ms", "more"] and lines[2].split() == ["b", "2", "x"]


def test_intervals_hold_the_median():
    samples = np.random.default_rng(2).normal(3.0, 0.1, 40)
    found = interval(samples)
    assert found["low"] < np.median(samples) < found["high"] < found["low"] + 0.2
    assert ratio(2.0 * samples, samples) == {"value": 2.0, "low": 2.0, "high": 2.0}


def test_memory_is_that_of_this_process():
    before = peak_mib()
    block = np.ones(2**24)
    assert block.nbytes / 2**20 < peak_mib() < before + 2 * block.nbytes / 2**20


def test_batches_are_the_same_every_time_and_effects_are_small_or_off():
    first, second = columns(5), columns(5)
    assert all(np.array_equal(first[name], second[name]) for name in first)
    known = tuple(effects().values())
    assert with_effects(known, 0.0).present_effects() == ()
    assert with_effects(known, 0.01).present_effects() == known
    assert with_effects(known, 0.0).compiled() is Hand().compiled()
