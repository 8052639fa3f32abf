"""The benchmark `described`: what it hides, and what it counts."""

from benchmarks.described import CASES, FIRST_SEED, OTHER, figures, hidden, plan
from benchmarks.naming_study.draw import amplitudes
from benchmarks.truth.effects import OPENED, OUTSIDE, SIZES
from benchmarks.truth.protocol import PROTOCOLS


def test_opened_kinds_of_the_study_are_hidden_within_their_range():
    drawn = [hidden(FIRST_SEED + k) for k in range(CASES)]
    kinds = {name.partition(".")[0] for each in drawn for name in each}
    assert kinds == {name.partition(".")[0] for name in amplitudes(OUTSIDE)}
    assert kinds <= set(OPENED)
    for name, size in (pair for each in drawn for pair in each.items()):
        assert SIZES[name].low <= size <= SIZES[name].high
        if SIZES[name].amplitude:
            assert size >= 0.2 * SIZES[name].high


def test_other_commands_come_after_those_of_the_campaign():
    names = [each.name for each in plan().conditions]
    assert names[-len(OTHER) :] == list(OTHER)
    assert plan().runs[:12] == PROTOCOLS["poor"].runs


def row(elsewhere, shows, **more):
    return {
        "hidden": {"nonlinear_spring.cubic": 0.02}, "verdict": "unknown", "shape": "generic",
        "closes": 0.9, "elsewhere": elsewhere, "shows": shows, **more,
    }  # fmt: skip


def test_the_median_is_of_cases_that_show():
    done = [row(0.9, 5.0), row(0.5, 5.0), row(0.7, 9.0), row(0.0, 2.0), {"not_made": "no hand"}]
    rows, (median, names) = figures(done)
    assert len(rows) == 4 and median["value"] == 0.7 and names["value"] == 0
    assert figures([row(0.0, 5.0, named=["gear_load"])])[1][1]["value"] == 1
