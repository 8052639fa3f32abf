"""What a diagnosis must stand beside recordings that were not fitted, and in any place of them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from sled import HARDENING, TIMES, UNITS, Sled, found

from hannes.campaigns.campaign import Entry
from hannes.campaigns.segments import Segment
from hannes.core.recording.recording import Recording
from hannes.identification.diagnosis import work_bound
from hannes.identification.diagnosis.decision import Decision
from hannes.identification.diagnosis.hold_out_guard import Stages, guarded
from hannes.identification.diagnosis.reservations import _further
from hannes.identification.diagnosis.score_test import Guess
from hannes.identification.diagnosis.tuning import VERDICT
from hannes.identification.gap_change import gap_changes, refusal, too_faint
from hannes.identification.remainder import _brief, largest, remainders

POINTS = tuple(SimpleNamespace(x=np.zeros(1), name=name) for name in ("given", "base", "found"))
FLOORS = {"position": 0.01, "speed": 0.1}
WAVE = np.sin(6.0 * TIMES)


def segments(runs=6, seed=0):
    """Repeats of one command: position is a wave that differs in size from run to run, noise."""
    made = []
    for k in range(runs):
        rng = np.random.default_rng([seed, k])
        size = 1.0 + 0.005 * rng.standard_normal()
        channels = {
            "time": TIMES,
            "drive": np.sin(TIMES),
            "position": size * WAVE + 0.01 * rng.standard_normal(TIMES.size),
            "speed": 0.1 * rng.standard_normal(TIMES.size),
        }
        entry = Entry(f"{k}.csv", Recording(channels, UNITS), "pushed", "show" if k > 4 else "fit")
        made.append(Segment(entry, entry.role, np.ones(TIMES.size, bool)))
    return made


def stages(*runs, failed=()):
    """Simulations as given, refitted, and with what was found; the same for every repeat."""
    these = segments()
    many = tuple([run] * len(these) for run in runs)
    return Stages(Sled(), these, FLOORS, FLOORS, POINTS, many, frozenset(failed))


def run(position=WAVE, speed=0.0 * WAVE):
    """Channels of one simulation."""
    return {"position": position, "speed": speed}


def decided(kind="named", *effects):
    """A decision before the guard."""
    return Decision(kind, effects, "it fits", POINTS[2])


LACKING = run(0.9 * WAVE)
RIGHT = run()


def change(before, after):
    """Of the unfitted recording's gaps."""
    return stages(before, before, after).change(1, 2)


def test_a_gap_that_falls_beyond_chance_is_better_and_one_that_rises_is_worse():
    position, speed = change(LACKING, RIGHT)
    assert position.better and position.could_show and not position.worse
    assert not (speed.better or speed.worse)
    position, _ = change(RIGHT, LACKING)
    assert position.worse and "that of the position from 0.0" in position.text


def test_what_moves_less_than_runs_differ_is_neither_and_is_called_faint():
    moved = change(RIGHT, run(1.002 * WAVE))
    assert not any(each.better or each.worse for each in moved)
    assert refusal(moved) == "" and too_faint(moved)


def test_of_an_unknown_no_machine_is_taken_that_nobody_has():
    names = SimpleNamespace(parameters=[SimpleNamespace(name="sled.mass")])
    for size, taken in ((9.0, True), (-28.0, False)):
        base = SimpleNamespace(x=np.array([size]), name="base", space=names)
        made = replace(stages(LACKING, RIGHT, RIGHT), points=(POINTS[0], base, POINTS[2]))
        found = guarded(decided("unknown"), made)
        assert found.refitted is taken
        assert found.decision.point is (base if taken else POINTS[0])
        said = "it takes sled.mass 28 times as far from its given value as scatter allows"
        assert found.cautions == ([] if taken else [f"the refitted baseline is not taken: {said}"])


def test_a_name_is_not_compared_with_a_machine_that_nobody_has():
    """A refit may do what the effect does, by a value that is 28 times as far off as it can be."""
    names = SimpleNamespace(parameters=[SimpleNamespace(name="sled.mass")])
    base, other = (run(WAVE + 0.018 * wave(25.0 * TIMES)) for wave in (np.sin, np.cos))
    for size, verdict, kept in (
        (9.0, "named", "unknown"),
        (-28.0, "named", "named"),
        (-28.0, "one_of", "one_of"),
        (-28.0, "named_with_remainder", "unknown"),
    ):
        point = SimpleNamespace(x=np.array([size]), name="base", space=names)
        made = replace(stages(run(0.7 * WAVE), base, other), points=(POINTS[0], point, POINTS[2]))
        stood = guarded(decided(verdict, "slack"), made)
        assert stood.decision.kind == kept and stood.refitted is (size > 0.0)
        assert len(stood.cautions) == (size < 0.0)
    rising = run(WAVE + 0.03 * np.sin(25.0 * TIMES))
    worse = replace(stages(run(0.7 * WAVE), RIGHT, rising), points=made.points)
    assert "raises the gap" in guarded(decided("named", "slack"), worse).decision.reason
    lacking = replace(stages(run(0.7 * WAVE), LACKING, RIGHT), points=made.points)
    assert guarded(decided("named", "slack"), lacking).refitted  # it stands beside that, too


def test_two_repeats_say_that_they_could_hardly_show_a_rise():
    few = replace(stages(LACKING, RIGHT, RIGHT), segments=segments()[-2:], runs=([LACKING] * 2,
                  [RIGHT] * 2, [RIGHT] * 2))  # fmt: skip
    said = guarded(decided("recalibrated"), few).cautions
    assert any("only a rise of the gap beyond 64 standard deviations" in each for each in said)
    assert guarded(decided("recalibrated"), stages(LACKING, RIGHT, RIGHT)).cautions == []


def test_a_run_without_repeats_is_taken_to_differ_by_the_noise_floor_throughout_a_block():
    alone = replace(stages(LACKING, run(0.995 * WAVE), RIGHT), segments=segments()[-1:],
                    runs=([LACKING], [run(0.995 * WAVE)], [RIGHT]))  # fmt: skip
    assert alone.change(0, 2)[0].better and alone.change(2, 0)[0].worse
    assert not any(each.better or each.worse for each in alone.change(1, 2))


def test_a_rise_is_rarely_seen_where_there_is_none():
    """The better simulation of two is called worse in one of a hundred at most, by its spread."""
    worse = 0
    for seed in range(200):
        these = segments(seed=seed + 1)
        before, after = (
            [{n: sim[n] - these[-1].recording[n] for n in FLOORS}] for sim in (LACKING, RIGHT)
        )
        near = [{n: run(0.998 * WAVE)[n] - these[-1].recording[n] for n in FLOORS}]
        worse += any(e.worse for e in gap_changes(Sled(), these, these[-1:], near, after, FLOORS))
        assert not any(
            e.worse for e in gap_changes(Sled(), these, these[-1:], before, after, FLOORS)
        )
    assert worse <= 6


def test_a_name_that_raises_one_gap_is_withdrawn_though_another_falls():
    ripple = 0.5 * np.sin(300.0 * TIMES)
    stood = guarded(decided("named", "slack"), stages(LACKING, LACKING, run(speed=ripple)))
    assert (stood.decision.kind, stood.decision.effects) == ("unknown", ())
    assert "raises the gap, that of the speed from 0.0" in stood.decision.reason
    assert stood.decision.point is POINTS[1]
    assert stood.stages.raw(2)[0]["speed"] == pytest.approx(stood.stages.raw(1)[0]["speed"])


def test_a_name_that_lowers_no_gap_though_it_would_show_is_withdrawn():
    other = run(WAVE + 0.1 * np.cos(25.0 * TIMES))
    middle = run(WAVE + 0.1 * np.sin(25.0 * TIMES))
    stood = guarded(decided("named", "slack"), stages(middle, middle, other))
    assert stood.decision.kind == "unknown"


@pytest.mark.parametrize(
    ("more", "per_bin", "refused"), [(1.0, 1.0, False), (-1.0, 1.0, True), (1.0, 2.0, True)]
)
def test_no_gap_need_fall_where_held_out_runs_show_a_name_that_leaves_noise(more, per_bin, refused):
    other, middle = (run(WAVE + 0.1 * wave(25.0 * TIMES)) for wave in (np.cos, np.sin))
    point = SimpleNamespace(x=np.zeros(1), chi2=100.0 * per_bin, residual=np.zeros(100))
    shown = {"point": point, "held_out": VERDICT.heldout_shown + more}
    decision = replace(decided("named", "slack"), **shown)
    reason = guarded(decision, stages(middle, middle, other)).decision.reason
    assert ("no gap falls" in reason) is refused


def test_a_right_name_stands():
    stood = guarded(decided("named", "slack"), stages(LACKING, LACKING, RIGHT))
    assert (stood.decision.kind, stood.cautions, stood.refitted) == ("named", [], True)


def test_a_refitted_baseline_that_oscillates_is_not_taken():
    """Between bins a refit may do anything: what was seen swung by 28 A where 0.06 A were off."""
    swings = run(speed=20.0 * np.sin(1500.0 * TIMES))
    stood = guarded(decided("recalibrated"), stages(run(0.99 * WAVE), swings, swings))
    assert not stood.refitted and stood.decision.kind == "no_gap"
    assert stood.decision.point is POINTS[0]
    assert stood.cautions[0].startswith("the refitted baseline is not taken: on recordings that")
    far = guarded(decided("recalibrated"), stages(LACKING, swings, swings))
    assert far.decision.kind == "unknown" and "times the noise floor" in far.decision.reason


def test_what_cannot_be_simulated_whole_is_not_taken():
    stood = guarded(decided("named", "slack"), stages(LACKING, LACKING, LACKING, failed=[2]))
    assert stood.decision.kind == "unknown" and "cannot be simulated" in stood.decision.reason


def test_a_remainder_is_found_where_it_is():
    """Five noise floors in one tenth of a run are hardly more than one in its RMS."""
    local = WAVE + 0.05 * (TIMES > 0.9)
    sled = Sled()
    sled.phases = lambda recording: {"early": TIMES <= 0.9, "late": TIMES > 0.9}
    these = stages(LACKING, LACKING, run(local))
    found = remainders(sled, these.segments, these.raw(1), these.raw(2), FLOORS)
    worst = largest(found)
    assert (worst.channel, worst.phase) == ("position", "late") and 4.0 < worst.after < 6.0
    assert largest(remainders(sled, these.segments, these.raw(1), these.raw(1), FLOORS))
    quiet = stages(LACKING, LACKING, RIGHT)
    assert largest(remainders(sled, quiet.segments, quiet.raw(1), quiet.raw(2), FLOORS)) is None


def test_no_gap_with_a_large_remainder_somewhere_is_unknown():
    """As given the whole is near, and one phase of one channel is not."""
    local, sled = run(WAVE + 0.05 * (TIMES > 0.9)), Sled()
    sled.phases = lambda recording: {"early": TIMES <= 0.9, "late": TIMES > 0.9}
    stood = guarded(decided("no_gap"), replace(stages(local, local, local), plant=sled))
    assert stood.decision.kind == "unknown" and "as given it leaves" in stood.decision.reason
    assert guarded(decided("no_gap"), stages(RIGHT, RIGHT, RIGHT)).decision.kind == "no_gap"


def test_what_is_left_as_given_and_not_refitted_is_recalibrated():
    other = run(0.97 * WAVE)
    stood = guarded(decided("no_gap"), stages(other, RIGHT, RIGHT))
    assert stood.decision.kind == "recalibrated"
    assert "it fits, but as given it leaves" in stood.decision.reason
    still = guarded(decided("no_gap"), stages(other, other, other))
    assert still.decision.kind == "unknown"


def test_a_machine_as_given_that_a_refit_comes_far_nearer_than_is_recalibrated():
    """What runs are stated to differ by may hide it: still the refitted values are the better."""
    wide = {"stated": [{"position": 0.1 * np.ones(TIMES.size)}] * 6}
    other = replace(stages(run(0.95 * WAVE), RIGHT, RIGHT), **wide)
    stood = guarded(decided("no_gap"), other)
    assert stood.decision.kind == "recalibrated"
    assert "refitted values lower the gap of recordings not fitted" in stood.decision.reason
    names = SimpleNamespace(parameters=[SimpleNamespace(name="sled.mass")])
    far = SimpleNamespace(x=np.array([-28.0]), name="base", space=names)
    nobody = replace(other, points=(POINTS[0], far, POINTS[2]))
    assert guarded(decided("no_gap"), nobody).decision.kind == "no_gap"
    little = replace(stages(run(0.998 * WAVE), RIGHT, RIGHT), **wide)
    assert guarded(decided("no_gap"), little).decision.kind == "no_gap"


def test_a_touch_that_comes_a_moment_earlier_leaves_nothing_of_a_force():
    """A blow of two samples, which no two runs share; as much for longer, or often, counts."""
    sled = Sled()
    sled.channels = {**Sled.channels, "position": "N"}

    def left(more):
        these = stages(LACKING, LACKING, run(WAVE + more))
        return largest(remainders(sled, these.segments, these.raw(1), these.raw(2), FLOORS))

    count = np.arange(TIMES.size)
    assert left(3.0 * (count == 70)) is None
    assert left(0.5 * (abs(count - 70) < 20)) is not None
    assert left(0.1 * (-1.0) ** count) is not None


@pytest.mark.parametrize("samples", [401, 1079, 1151, 2001])
@pytest.mark.parametrize(("rate", "brief"), [(1000.0, 11), (2000.0, 21), (100.0, 1)])
def test_a_blow_is_as_long_whatever_the_recording(samples, rate, brief):
    assert _brief(5.003 + np.arange(samples) / rate) == brief


def test_a_name_with_a_large_remainder_is_unknown():
    left = run(0.97 * WAVE)
    stood = guarded(decided("named_with_remainder", "slack"), stages(LACKING, LACKING, left))
    assert stood.decision.kind == "unknown" and "it leaves" in stood.decision.reason


def test_a_linear_estimate_is_never_stated_as_a_fact():
    guess = Guess("gear_load", 40.0, np.zeros(1, int), np.zeros(1), np.zeros((1, 1)))
    state = SimpleNamespace(variance_factor=1.0)
    assert _further(state, guess).startswith("by a linear estimate, not fitted, 40 more")
    fitted = replace(guess, refitted=True)
    assert _further(state, fitted) == "gear load beside it lowers the misfit by 40 more"
    verdict = found(1, ((HARDENING, 900.0),))
    refitted = {row["effect"]: row["refitted"] for row in verdict.candidates}
    for row in verdict.tried:
        assert refitted[row["effect"]] or row["accepted"] or "linear estimate" in row["why"]


def test_a_search_that_reaches_its_bound_is_unknown_and_says_so(monkeypatch):
    monkeypatch.setattr(work_bound, "SEARCH", replace(work_bound.SEARCH, most_simulated=300.0))
    verdict = found(1, ((HARDENING, 901.0),))
    assert (verdict.verdict, verdict.effects) == ("unknown", [])
    assert verdict.reason.startswith("the search was ended at its bound, 300 s of single runs")


def test_a_verdict_of_absence_says_what_could_not_have_shown():
    verdict = found(2)
    assert verdict.verdict == "recalibrated"
    assert any("repeats alone" in each for each in verdict.cautions)


def test_two_repeats_that_agree_by_chance_make_no_remainder():
    """Their difference is one draw: where it is small, the noise floor of the channel counts."""
    off = [run(WAVE + 0.012 + 0.0001 * k) for k in range(2)]
    pair = [{n: each[n] - WAVE * (n == "position") for n in FLOORS} for each in off]
    found = remainders(Sled(), segments()[:2], pair, pair, FLOORS)
    assert largest(found) is None and found[0].after < 1.5


def test_four_repeats_that_agree_by_chance_count_beside_what_is_stated_of_the_place():
    """Runs that start at other supplies differ by one number each: four may be alike."""
    off = [0.002 * (k % 2) + 0.012 + 0.001 * WAVE for k in range(4)]
    these = [{"position": each} for each in off]
    noise_floors = {"position": 0.005}
    alone = remainders(Sled(), segments()[:4], these, these, noise_floors)
    assert largest(alone) is not None
    stated = [{"position": 0.01 * np.ones(TIMES.size)}] * 4
    assert largest(remainders(Sled(), segments()[:4], these, these, noise_floors, stated)) is None
    unfitted = [{}, *stated[1:]]
    assert largest(remainders(Sled(), segments()[:4], these, these, noise_floors, unfitted)) is None
    little = [{"position": 0.001 * np.ones(TIMES.size)}] * 4
    assert (
        largest(remainders(Sled(), segments()[:4], these, these, noise_floors, little)) is not None
    )
