"""The naming study of hands whose fingers differ: what it draws, how it scores and counts."""

import json
from collections import Counter

import numpy as np
import pytest
from scipy.linalg import cho_factor

from benchmarks.naming_study.apart import bench, kinds, parting, score, summary, work
from benchmarks.naming_study.apart.draw import BANDWIDTHS, Hidden, drawn
from benchmarks.naming_study.apart.kinds import KINDS, NAMED, SETS, cases, first_seed
from benchmarks.truth.campaign import make
from benchmarks.truth.effects import OPENED, SEALED
from benchmarks.truth.faults import RANGES, Fault
from benchmarks.truth.hidden import SIZES
from benchmarks.truth.protocol import POOR, Condition, Protocol
from hannes.campaigns.campaign_file import read_campaign
from hannes.core.errors import ComputationFailed

BLINK = Protocol((Condition("void", ((0.0, 0.0), (0.1, 1.5)), 2),), POOR)
TURN = Fault("weak_spring", "ring", "mcp", 0.6)


def seeds(name, chosen="quoted"):
    first = first_seed(NAMED[name], chosen)
    return range(first, first + NAMED[name].counts[chosen])


def said(verdict, *effects):
    return {"verdict": verdict, "effects": list(effects), "reason": ""}


def test_the_quoted_set_has_the_cases_of_its_table():
    counts = Counter()
    for name, _ in cases("quoted"):
        kind = NAMED[name]
        counts[kind.what] += 1
        counts[kind.what, kind.protocol] += 1
        counts["coloured"] += kind.coloured
    assert [counts[w] for w in ("single", "sound", "pair", "triple", "fault")] == [
        150, 120, 30, 12, 24,
    ]  # fmt: skip
    assert counts["opened"] == counts["sealed"] == 20 and counts["coloured"] == 30
    assert [counts["single", p] for p in ("naive", "poor", "rich")] == [50, 50, 50]
    assert counts["sound", "naive"] == 30
    assert [counts[f"MuJoCo {w}"] for w in ("sound", "slack", "load")] == [12, 6, 6]


def test_seeds_of_the_sets_never_meet():
    drawn = [{seed for _, seed in cases(chosen)} for chosen in SETS]
    assert not drawn[0] & drawn[1]
    assert all(kinds.is_quoted(s) for s in drawn[1]) and not any(map(kinds.is_quoted, drawn[0]))
    assert max(map(max, (kind.counts.values() for kind in KINDS))) < kinds.APART


def test_quick_cases_are_of_the_development_set():
    quick = cases("development", quick=True)
    assert set(quick) <= set(cases("development")) and 0 < len(quick) < 5


def test_development_never_hides_a_sealed_kind():
    assert not [name for name, _ in cases("development") if NAMED[name].what == "sealed"]
    hidden = {
        effect
        for name, seed in cases("development")
        if NAMED[name].what == "opened"
        for attempt in range(20)
        for effect in drawn(NAMED[name], seed, attempt).effects
    }
    assert hidden == set(OPENED)
    with pytest.raises(ValueError, match="quoted set alone"):
        drawn(NAMED["sealed, poor"], first_seed(NAMED["sealed, poor"], "development"))


def test_the_quoted_set_hides_every_sealed_kind():
    sealed = [
        drawn(NAMED[f"sealed, {p}"], s) for p in ("poor", "rich") for s in seeds(f"sealed, {p}")
    ]
    assert {effect for each in sealed for effect in each.effects} == set(SEALED)
    for size, name in ((h.sizes[n], n) for h in sealed for n in h.sizes):
        assert SIZES[name].low - 1e-12 <= size <= SIZES[name].high * (1.0 + 1e-12)


def test_faults_are_within_their_ranges_and_of_every_kind():
    found = [drawn(NAMED["fault, poor"], seed, attempt).fault
             for seed in seeds("fault, poor") for attempt in (0, 5)]  # fmt: skip
    assert {fault.kind for fault in found} == set(RANGES)
    for fault in found:
        assert RANGES[fault.kind][0] - 1e-9 <= fault.size <= RANGES[fault.kind][1] + 1e-9
    assert Hidden(fault=TURN).effects == ["ring_weak_spring"]


def test_a_quarter_of_the_sound_hands_has_coloured_noise():
    for name, seed in cases("quoted"):
        if NAMED[name].what == "sound":
            hidden = drawn(NAMED[name], seed)
            assert not hidden.effects
            assert (hidden.bandwidth is not None) == NAMED[name].coloured
            assert hidden.bandwidth is None or BANDWIDTHS[0] <= hidden.bandwidth <= BANDWIDTHS[1]


def test_commands_that_are_not_given_are_no_protocols():
    given = {(c.points, str(c.thing)) for plan in bench.PLANS.values() for c in plan.conditions}
    assert not given & {(c.points, str(c.thing)) for c in bench.ELSEWHERE}


@pytest.fixture
def blink(monkeypatch):
    monkeypatch.setattr(bench, "PLANS", dict.fromkeys(bench.PLANS, BLINK))
    return BLINK


def test_what_shows_is_counted_in_floors_of_runs(blink):
    sound = make(blink, 5)
    assert bench.shown(sound, sound) == 0.0
    small, large = (bench.shown(make(blink, 5, {"current_offset.offset": x}), sound)
                    for x in (1e-3, 0.2))  # fmt: skip
    assert small < bench.SHOWS < large


def test_a_draw_that_does_not_show_or_cannot_be_made_is_drawn_again(blink, monkeypatch):
    kind, asked = NAMED["fault, poor"], []
    shows = iter((1.0, 2.0, 9.0))
    monkeypatch.setattr(bench, "shown", lambda made, sound: next(shows))
    monkeypatch.setattr(
        bench, "drawn", lambda kind, seed, attempt: asked.append(attempt) or Hidden(fault=TURN)
    )
    assert bench.case(kind, 7).shows == 9.0 and asked == [0, 1, 2]

    def stuck(*given, **more):
        raise ComputationFailed("stuck")

    monkeypatch.setattr(bench, "make", stuck)
    with pytest.raises(ComputationFailed, match="24 draws"):
        bench.case(NAMED["sound, poor"], 7)


def test_the_answer_and_other_commands_are_out_of_reach(tmp_path, monkeypatch):
    quick = Condition("void", ((0.0, 0.0), (0.1, 1.5)), 2)
    beside = Condition("void, 0.3 speed", ((0.0, 0.0), (0.2, 1.5)), 1)
    made = make(Protocol((quick, beside), POOR), 5, {"gear_load.coefficient": 0.1})
    for stated in (True, False):
        folder = tmp_path / str(stated)
        folder.mkdir()
        file = bench.written(made, stated, folder)
        files = {path.name for path in folder.rglob("*") if path.is_file()}
        assert not {name for name in files if "answer" in name or "03" in name}
        text = file.read_text(encoding="utf-8")
        assert ("scatter" in text) == stated and "gear_load" not in text
        assert len(read_campaign(file).entries) == 2


@pytest.mark.parametrize(
    ("what", "verdict", "effects", "outcome"),
    [
        ("single", said("named", "capstan"), ["capstan"], "right"),
        ("single", said("named_with_remainder", "capstan"), ["capstan"], "right"),
        ("single", said("named", "capstan", "gear_load"), ["capstan"], "wrong"),
        ("single", said("one_of", "capstan", "gear_load"), ["capstan"], "class"),
        ("single", said("one_of", "stribeck", "gear_load"), ["capstan"], "wrong"),
        ("single", said("unknown"), ["capstan"], "unknown"),
        ("single", said("recalibrated"), ["capstan"], "silent"),
        ("sound", said("recalibrated"), [], "silent"),
        ("sound", said("no_gap"), [], "silent"),
        ("sound", said("unknown"), [], "called"),
        ("sound", said("failed"), [], "called"),
        ("sound", said("one_of", "capstan", "gear_load"), [], "named"),
        ("opened", said("named_with_remainder", "capstan"), ["wire_creep"], "wrong"),
        ("sealed", said("unknown"), ["soft_pad"], "unknown"),
        ("pair", said("named", "a", "b"), ["b", "a"], "both"),
        ("pair", said("named_with_remainder", "a"), ["b", "a"], "one"),
        ("pair", said("named", "a", "c"), ["b", "a"], "wrong"),
        ("triple", said("named", "a", "b", "c"), ["c", "b", "a"], "all"),
        ("triple", said("named", "a", "b"), ["c", "b", "a"], "two"),
        ("triple", said("named_with_remainder", "a", "b"), ["c", "b", "a"], "two"),
        ("triple", said("named_with_remainder", "a"), ["c", "b", "a"], "one"),
        ("triple", said("named", "a", "b", "d"), ["c", "b", "a"], "wrong"),
        ("MuJoCo sound", said("recalibrated"), [], "silent"),
        ("MuJoCo sound", said("named", "stribeck"), [], "law"),
        ("MuJoCo sound", said("named", "current_gain"), [], "wrong"),
        ("MuJoCo slack", said("named", "leader_slack", "stribeck"), ["leader_slack"], "right"),
        ("MuJoCo slack", said("named", "leader_slack", "force_lag"), ["leader_slack"], "wrong"),
        ("MuJoCo slack", said("one_of", "leader_slack", "capstan"), ["leader_slack"], "class"),
        ("MuJoCo load", said("named", "stribeck"), ["gear_load"], "wrong"),
        ("MuJoCo load", said("unknown"), ["gear_load"], "unknown"),
    ],
)
def test_outcomes(what, verdict, effects, outcome):
    assert score.outcome(what, verdict, effects, None) == outcome


@pytest.mark.parametrize(
    ("verdict", "outcome"),
    [
        (said("named", "ring_weak_spring"), "right"),
        (said("named", "index_weak_spring"), "wrong"),
        (said("named", "ring_stiff_joint"), "wrong"),
        (said("one_of", "ring_weak_spring", "index_weak_spring"), "class"),
        (said("one_of", "ring_weak_spring", "index_stiff_joint"), "wrong"),
        (said("unknown"), "unknown"),
    ],
)
def test_a_fault_needs_its_kind_and_its_finger_or_a_class_of_fingers(verdict, outcome):
    assert score.outcome("fault", verdict, ["ring_weak_spring"], TURN) == outcome


def row(name, seed, outcome, seconds=10.0, named=("capstan",), **more):
    kind = NAMED[name]
    return {
        "kind": name, "seed": seed, "what": kind.what, "protocol": kind.protocol,
        "outcome": outcome, "verdict": "named", "named": list(named),
        "effects": [] if kind.what == "sound" else ["capstan"],
        "parameters": {}, "processor_seconds": seconds, "probability": None, **more,
    }  # fmt: skip


def shown(done):
    return {
        each["name"].rpartition(", of ")[0] or each["name"]: each
        for each in summary.figures(done)[1]
    }


def test_every_case_is_in_the_denominator_and_a_late_one_is_wrong():
    done = [row("single, poor", k, "right") for k in range(45)]
    done += [row("single, poor", 45, "right", seconds=130.0)]
    done += [row("single, poor", k, "unknown") for k in range(46, 50)]
    found = shown(done)
    right = found["single effects: right or a class"]
    assert right["value"] == 45 and right["bound"] == 45.0 and right["holds"]
    assert found["single effects: wrong name or no answer"]["value"] == 1


def test_a_bound_missed_by_one_standard_error_is_shown_as_such():
    for right, missed in ((135, ""), (132, "by one standard error or less"), (131, "yes")):
        done = [row("single, poor", k, "right" if k < right else "unknown") for k in range(150)]
        found = shown(done)["single effects: right or a class"]
        assert found["missed"] == missed and found["holds"] == (not missed)


def test_rows_of_the_table():
    done = [row("sound, poor", k, "silent") for k in range(119)]
    done += [row("sound, poor", 119, "named"), row("pair, rich", 1, "both")]
    done += [row("triple, rich", 1, "two"), row("fault, poor", 1, "class", named=["a", "b", "c"])]
    done += [row("opened, poor", k, "unknown", elsewhere=x) for k, x in enumerate((0.2, 0.7, 0.9))]
    off = {"capstan.friction": {"error": 0.02, "covers": True}}
    done += [row("single, naive", k, "right", parameters=off) for k in range(3)]
    found = shown(done)
    assert found["sound: named"]["value"] == 1 and found["sound: named"]["holds"]
    assert found["sound: anything but silent"]["value"] == 1
    assert (
        found["pairs: both named"]["holds"]
        and found["triples: two or more named, none wrong"]["value"] == 1
    )
    assert not found["fingers of that class, mean"]["holds"]
    assert found["the same: gap closed on another command, median"]["value"] == 0.7
    assert found["single, naive: right or a class"]["bound"] == pytest.approx(2.4)
    assert found["error of a named size, median"]["value"] == 0.02
    assert not found["coverage of 95 % intervals"]["holds"]
    json.dumps(summary.figures(done), allow_nan=False)
    assert {each["outcome"] for each in summary.missing(done)} == {"named"}


def test_rows_of_mujocos_hands():
    done = [row("MuJoCo sound, poor", k, "law") for k in range(11)]
    done += [row("MuJoCo sound, poor", 11, "wrong"), row("MuJoCo slack, poor", 0, "unknown")]
    done += [row("MuJoCo load, poor", k, "right") for k in range(2)]
    found = shown(done)
    assert found["MuJoCo, sound: a name that is no law it has otherwise"]["holds"]
    missed = found["MuJoCo, slack or load: missed or wrong"]
    assert missed["value"] == 1 and missed["bound"] == 1.0 and missed["holds"]


def test_what_cannot_be_made_is_counted_apart():
    done = [{"kind": "fault, poor", "seed": 1, "what": "fault", "protocol": "poor", "not_made": ""}]
    (only,), bounds = summary.figures(done)
    assert only["not made"] == 1 and bounds == [] and summary.missing(done) == []


def test_a_case_is_one_line_of_json(blink, monkeypatch):
    def ask(campaign):
        raise ComputationFailed("no answer")

    found = work.measured("sound, naive, coloured noise", 5, ask)
    assert found["outcome"] == "called" and found["verdict"] == "failed" and found["bandwidth_hz"]
    json.dumps(found, allow_nan=False)


def test_fingers_are_parted_by_what_no_size_of_theirs_explains():
    rng = np.random.default_rng(3)
    one, other, rest = rng.standard_normal((3, 30))
    factor = cho_factor(0.25 * np.eye(30))
    sizes = np.linspace(0.0, 1.0, 5)
    tables = [(sizes, np.outer(sizes, one)), (sizes, np.outer(sizes, other))]
    assert parting.least(0.6 * one + 0.3 * other, tables, factor) == pytest.approx(0.0, abs=1e-4)
    apart = rest - np.linalg.lstsq(np.array([one, other]).T, rest, rcond=None)[0] @ [one, other]
    wanted = 0.6 * one + 0.3 * other + apart
    assert parting.least(wanted, tables, factor) == pytest.approx(4.0 * apart @ apart, rel=1e-3)


def test_a_class_of_fingers_that_can_be_parted_is_too_wide(monkeypatch):
    for chi2, outcome in ((11.0, "class"), (13.0, "wide")):
        monkeypatch.setattr(work, "parted", lambda *given, chi2=chi2: {"index": chi2})
        case = bench.Case(Hidden(fault=TURN), None)
        row = {"outcome": "class", "named": ["ring_weak_spring", "index_weak_spring"]}
        found = work._fingers(NAMED["fault, naive"], 7, case, row)
        assert found == {"parted": {"index": chi2}, "outcome": outcome}
    assert work._fingers(NAMED["fault, naive"], 7, case, {**row, "outcome": "right"}) == {}
