"""The naming study: what it draws, that answers stay sealed, how it scores, that it resumes."""

import json

import numpy as np
import pytest

from benchmarks import naming, study
from benchmarks.naming_study import alike, draw, frozen, plan, records, score, summary, work
from benchmarks.naming_study.probabilities import probabilities
from benchmarks.oracle.shapes import shapes
from benchmarks.truth.effects import CATALOGUE, OUTSIDE, SIZES
from benchmarks.truth.protocol import RICH, Condition, Protocol
from benchmarks.truth.record import checked
from hannes.core.recording.recording import Recording
from hannes.plants.hand.candidate_runs import proposals

BLINK = Protocol((Condition("void", ((0.0, 0.0), (0.1, 1.5)), 2),), RICH)
GAP = {"current": {"unit": "A", "as_given": 0.2, "before": 0.1, "after": 0.02, "floor": 0.01}}
SLACK = {"leader_slack.length": {"value": 3.1e-3, "unit": "m", "low": 2.9e-3, "high": 3.3e-3}}
CANDIDATES = [
    {"effect": "leader_slack", "evidence": 9.0, "gain_select": 0.9, "confusable_with": []},
    {"effect": "capstan", "evidence": 1.0, "gain_select": 0.2, "confusable_with": []},
]


def said(verdict, *effects, parameters=SLACK):
    return {
        "verdict": verdict,
        "effects": list(effects),
        "gap": GAP,
        "parameters": parameters,
        "candidates": CANDIDATES,
        "next_run": None,
    }


@pytest.mark.parametrize("protocol", ["poor", "rich"])
def test_every_amplitude_has_a_frozen_size_in_its_physical_range(protocol):
    known = frozen.smallest(protocol)
    assert set(known) <= {name for name, size in SIZES.items() if size.amplitude}
    assert len(known) >= 27
    for name, each in known.items():
        assert [dict(one.shape) for one in each] == shapes(name), name
        assert all(one.u is None or 0.0 < one.u <= SIZES[name].high for one in each), name
    assert sum(one.u is not None for each in known.values() for one in each) > 40


def test_times_u_are_times_that_of_the_shape_that_is_hidden():
    for seed in range(200):
        case = draw.drawn("single", "rich", seed)
        ((name, times),) = case.times.items()
        shape = {key: value for key, value in case.hidden.items() if key != name}
        (u,) = [one.u for one in frozen.smallest("rich")[name] if dict(one.shape) == shape]
        assert times == (None if u is None else pytest.approx(abs(case.hidden[name]) / u))


@pytest.mark.parametrize("what", ["single", "pair", "outside", "closures", "empty"])
def test_what_is_hidden_follows_from_the_seed_alone(what):
    for seed in range(60):
        case = draw.drawn(what, "poor", seed)
        assert case == draw.drawn(what, "poor", seed) == draw.drawn(what, "poor, duty", seed)
        assert len(case.effects) == {"pair": 2, "empty": 0}.get(what, 1)
        assert len(set(case.effects)) == len(case.effects)
        checked(case.hidden)
        for name, size in case.hidden.items():
            assert abs(size) <= max(SIZES[name].high, -SIZES[name].low), name
        if case.least_times is not None:
            assert (draw.PAIRED if what == "pair" else draw.LEAST) <= case.least_times <= draw.MOST
    assert draw.drawn("single", "poor", 1) != draw.drawn("single", "poor", 2)


def test_all_effects_are_hidden_with_both_signs_and_over_their_shapes():
    for what, effects in (("single", CATALOGUE), ("outside", OUTSIDE)):
        names = draw.amplitudes(effects)
        drawn = [draw.drawn(what, "poor", seed) for seed in range(20 * len(names))]
        assert {name for case in drawn for name in case.times} == set(names)
        for name in names:
            sizes = [case.hidden[name] for case in drawn if name in case.times]
            assert {np.sign(x) for x in sizes} == ({-1.0, 1.0} if SIZES[name].low < 0 else {1.0})
    joints = {
        case.hidden["friction_step.joint"] for case in drawn if "friction_step.joint" in case.hidden
    }
    assert joints <= set(range(10)) and len(joints) == 5


def test_seeds_of_development_and_of_quoted_figures_never_meet():
    seeds = {name: {seed for _, seed in plan.cases(name, False)} for name in plan.SETS}
    assert not seeds["development"] & seeds["quoted"]
    for chosen in plan.SETS:
        cases = plan.cases(chosen, False)
        assert len(cases) == len(set(cases))
        assert set(plan.cases(chosen, True)) <= set(cases)
    kinds = plan.NAMED
    again, first = kinds["single, poor, scatter assumed x0.5"], kinds["single, poor"]
    assert plan.first_seed(again, "quoted") == plan.first_seed(first, "quoted")
    assert plan.first_seed(kinds["empty, poor"], "quoted") != plan.first_seed(first, "quoted")


def test_a_study_has_the_cases_that_must_be_shown():
    count = {what: 0 for what in ("single", "empty", "outside", "pair")}
    for kind in plan.KINDS:
        if kind.assumed_ratio == 1.0 and kind.what in count:
            count[kind.what] += kind.counts[0]
    assert count["single"] >= 100 and count["empty"] >= 200


@pytest.mark.parametrize(
    ("verdict", "outcome"),
    [
        (said("named", "leader_slack"), "right"),
        (said("named_with_remainder", "leader_slack"), "right"),
        (said("one_of", "capstan", "leader_slack"), "class"),
        (said("one_of", "capstan", "gear_load"), "wrong"),
        (said("named", "capstan"), "wrong"),
        (said("named", "leader_slack", "capstan"), "wrong"),
        (said("unknown"), "unknown"),
        (said("no_gap"), "silent"),
        (said("recalibrated"), "silent"),
        (said("undecided"), "silent"),
        ({"verdict": "failed", "effects": []}, "silent"),
    ],
)
def test_a_single_effect_is_right_in_a_class_wrong_unknown_or_silent(verdict, outcome):
    assert score.single(verdict, "leader_slack") == outcome


def test_nothing_hidden_a_stranger_and_two_effects_are_scored():
    assert [score.empty(said(v, *e)) for v, e in (
        ("named", ["capstan"]), ("one_of", ["capstan", "gear_load"]), ("unknown", []),
        ("recalibrated", []),
    )] == ["named", "named", "unknown", "silent"]  # fmt: skip
    assert [score.outside(said(v)) for v in (
        "unknown", "named_with_remainder", "named", "one_of", "no_gap"
    )] == ["unknown", "remainder", "wrong", "wrong", "silent"]  # fmt: skip
    two = ["leader_slack", "capstan"]
    assert [score.pair(said(v, *e), two) for v, e in (
        ("named", two[::-1]), ("named_with_remainder", two[:1]), ("named", two[:1]),
        ("one_of", ["capstan", "gear_load"]), ("named", ["leader_slack", "gear_load"]),
        ("unknown", []), ("no_gap", []),
    )] == ["both", "one", "part", "part", "wrong", "unknown", "silent"]  # fmt: skip


def test_scores_hold_closing_placebo_error_and_coverage():
    case = {
        "verdict": said("named", "leader_slack"),
        "answer": {"leader_slack": {"length": 3e-3}},
        "left": {"before": 9.0, "after": 2.0},
    }
    found = score.scores("single", case, ["leader_slack"])
    assert found["left"]["after"] == 2.0
    assert found["placebo"] == 0.2
    found_value = found["parameters"]["leader_slack.length"]
    assert found_value["error"] == pytest.approx(0.1 / 3.0) and found_value["covers"]
    silent = {**case, "verdict": said("recalibrated", parameters={})}
    found = score.scores("single", silent, ["leader_slack"])
    assert found["parameters"] == {}
    wrong = score.scores("single", {**case, "verdict": said("named", "capstan")}, ["leader_slack"])
    assert wrong["outcome"] == "wrong"


def line(kind, seed, outcome, times=3.0, **more):
    effects = {"single": ["leader_slack"], "pair": ["leader_slack", "capstan"]}
    return {
        "kind": kind.name, "seed": seed, "what": kind.what, "protocol": kind.protocol,
        "assumed_ratio": kind.assumed_ratio, "effects": effects.get(kind.what, []),
        "hidden": {}, "times": times,
        "outcome": outcome, "verdict": "named", "named": ["leader_slack"],
        "left": {"before": 50.0, "after": 12.0},
        "placebo": 0.1, "parameters": {}, "next_run": None, "after": {}, "seconds": 2.0, **more,
    }  # fmt: skip


def shown(done):
    _, bounds = summary.figures(done)
    return {row["name"]: row for row in bounds}


def test_abstentions_stay_in_every_denominator():
    rich = plan.NAMED["single, rich"]
    done = [line(rich, k, "right") for k in range(8)] + [line(rich, 8, "silent")]
    done += [line(rich, 9, "wrong"), line(rich, 10, "right", times=1.0)]
    done += [line(rich, 11, "silent", times=None)]
    found = shown(done)
    right = found["single effect at 2 u or more, rich: right or class"]
    assert right["value"] == 0.8 and right["cases"] == 10 and not right["holds"]
    assert right["low"] < 0.8 < right["high"]
    assert found["single effect at 2 u or more, rich: wrong"]["value"] == 0.1
    assert found["share of the reducible gap closed"]["cases"] == 11
    assert found["share of the reducible gap closed"]["value"] == pytest.approx(38.0 / 50.0)
    assert found["nothing nameable hidden: wrong"]["value"] == 0.0


def test_what_is_not_named_closes_nothing_of_the_gap():
    rich = plan.NAMED["single, rich"]
    done = [line(rich, k, "right") for k in range(3)]
    assert shown(done)["share of the reducible gap closed"]["value"] == pytest.approx(38.0 / 50.0)
    done += [line(rich, k, "wrong") for k in range(3, 8)]
    assert shown(done)["share of the reducible gap closed"]["value"] == 0.0


def test_false_alarms_outsiders_and_pairs_have_their_bounds():
    kinds = plan.NAMED
    done = [line(kinds["empty, rich"], k, "named" if k < 3 else "silent", None) for k in range(100)]
    done += [line(kinds["outside, rich"], k, "unknown") for k in range(9)]
    done += [line(kinds["outside, rich"], 9, "wrong")]
    done += [line(kinds["outside, rich"], 10, "silent", times=0.6)]
    done += [line(kinds["pair, rich"], k, "both" if k < 3 else "one") for k in range(7)]
    done += [line(kinds["pair, rich"], 7 + k, "wrong") for k in range(3)]
    done += [line(kinds["single, poor"], k, "silent", None) for k in range(3)]
    done += [line(kinds["single, poor, scatter assumed x0.5"], 0, "wrong", None)]
    found = shown(done)
    assert (
        found["nothing nameable hidden: wrong"]["cases"] == 3
    )  # none with a wrong assumed scatter
    assert found["nothing hidden: named"]["value"] == 0.03
    assert not found["nothing hidden: named"]["holds"]
    assert found["nothing hidden: unknown"]["holds"]
    assert found["outside the catalogue: unknown or remainder"]["value"] == 0.9
    assert found["two effects: both, or one and a remainder"]["value"] == 0.7
    assert found["two effects: both, of these"]["value"] == pytest.approx(3 / 7)


def test_wrong_names_with_a_wrong_scatter_stand_beside_the_same_cases():
    kinds = plan.NAMED
    right, half = kinds["empty, poor"], kinds["empty, poor, scatter assumed x0.5"]
    done = [line(right, k, "named" if k in (0, 7) else "silent", None) for k in range(10)]
    done += [line(half, k, "named" if k < 3 else "silent", None) for k in range(5)]
    row = shown(done)["wrong names, scatter assumed x0.5"]
    assert row["value"] == 0.6 and row["bound"] == 0.4 and not row["holds"]


def test_intervals_of_parameters_are_counted():
    kind = plan.NAMED["single, poor"]
    found_value = [
        {"leader_slack.length": {"error": 0.01 * k, "covers": k != 3}} for k in range(20)
    ]
    found = shown([line(kind, k, "right", parameters=each) for k, each in enumerate(found_value)])
    assert found["coverage of 95 % intervals"]["value"] == 0.95
    assert found["coverage of 95 % intervals"]["holds"]
    assert found["error of the effect's parameter"]["value"] == pytest.approx(0.095)
    assert not found["error of the effect's parameter"]["holds"]


def test_the_error_of_a_parameter_stands_beside_what_the_oracles_power_bears():
    off = {"leader_slack.length": {"error": 0.02, "covers": True}}
    done = [line(plan.NAMED["single, rich"], k, "right", 2.0, parameters=off) for k in range(3)]
    rows, _ = summary.figures(done)
    (found,) = [row for row in rows if "as sharply as the oracle" in row.get("study", "")]
    draws = 1.0 + np.random.default_rng(0).standard_normal(400_000) / (2.0 * 2.4865)
    assert found["value"] == pytest.approx(np.median(np.abs(draws - 1.0)), rel=0.01)


def test_confusion_counts_answers_by_what_is_hidden():
    kind = plan.NAMED["single, poor"]
    done = [line(kind, 1, "right"), line(kind, 2, "wrong", named=["capstan"])]
    done += [line(kind, 3, "class", named=["leader_slack", "capstan"])]
    done += [line(kind, 4, "unknown", named=[], verdict="unknown")]
    done += [{"kind": kind.name, "seed": 5, "what": "single", "not_made": "no step converges"}]
    table = summary.confusion(done)
    assert table == {
        "leader_slack": {"leader_slack": 1, "capstan": 1, "capstan | leader_slack": 1, "unknown": 1}
    }
    (row,) = summary.confusion_rows(table)
    assert row["cases"] == 4 and "capstan 1" in row["answered"]
    rows, bounds = summary.figures(done)
    assert rows[0]["cases"] == 4 and rows[0]["not made"] == 1
    json.dumps([rows, bounds], allow_nan=False)


def test_the_answer_is_out_of_reach_until_the_verdict_is_on_disk():
    seen = {}

    def diagnose(campaign, out):
        files = sorted(p.relative_to(campaign.parent) for p in campaign.parent.rglob("*"))
        seen["files"] = [path.as_posix() for path in files]
        seen["campaign"] = campaign.read_text(encoding="utf-8")
        out.mkdir()
        (out / "verdict.json").write_text(json.dumps(said("named", "leader_slack")))

    case = draw.Drawn({"leader_slack.length": 3e-3}, {"leader_slack.length": 2.0})
    found = work.run_case(case, BLINK, 5, assumed_ratio=2.0, diagnose=diagnose)
    assert seen["files"] == ["01_void.h5", "02_void.h5", "campaign.toml", "hand.toml"]
    assert 'scatter = "4 %"' in seen["campaign"] and 'run_scatter = "1 %"' in seen["campaign"]
    assert found["answer"] == {"leader_slack": {"length": 3e-3}}
    assert score.scores("single", found, case.effects)["outcome"] == "right"


def test_records_of_the_quoted_set_are_never_begun_anew(monkeypatch, tmp_path):
    monkeypatch.setattr(naming, "RECORDS", tmp_path)
    asked = []
    monkeypatch.setattr(
        study, "run", lambda file, *rest: asked.append((file.parent, rest[2])) or []
    )
    ways = ([], ["--study", "alike"], ["--machine", "servo"])
    for chosen in (["--set", which, *way] for which in ("quoted", "development") for way in ways):
        monkeypatch.setattr("sys.argv", ["naming", *chosen])
        naming.main()
    assert asked == [(tmp_path, True)] * 3 + [(naming.FOLDER, False)] * 3


def test_lines_under_former_names_are_read_and_kept(tmp_path):
    file = tmp_path / "cases.jsonl"
    row = {"kind": "empty, poor, scatter told x0.5", "seed": 7, "told": 0.5, "after": {}}
    file.write_text(json.dumps(row) + "\n", encoding="utf-8")
    (found,) = records.read(file)
    assert found["kind"] in plan.NAMED and found["assumed_ratio"] == 0.5 and "told" not in found
    cases = [(found["kind"], 7), (found["kind"], 8)]
    rows = records.run(file, cases, lambda kind, seed: {"asked": kind}, resume=True)
    assert rows[0] == found and rows[1]["asked"] == found["kind"] == rows[1]["kind"]


def made_up(kind, seed):
    return {"double": 2 * seed}


@pytest.mark.parametrize("workers", [1, 2])
def test_a_study_goes_on_where_it_was_killed(tmp_path, workers):
    file, cases = tmp_path / "cases.jsonl", [("a", 1), ("a", 2), ("b", 1)]
    study.run(file, cases[:2], made_up, resume=False)
    with file.open("a") as stream:
        stream.write('{"kind": "b", "se')  # killed while it wrote
    kept = file.read_text().splitlines()[0].replace('"double": 2', '"double": 99')
    file.write_text("\n".join([kept, *file.read_text().splitlines()[1:]]))
    before = file.read_bytes()
    assert (
        len(list(study.read(file))) == 2 and file.read_bytes() == before
    )  # reading writes nothing
    found = study.run(file, cases, made_up, resume=True, workers=workers)
    assert [row["double"] for row in found] == [99, 4, 2]
    assert len(file.read_text().splitlines()) == 3
    assert [row["double"] for row in study.run(file, cases, made_up, resume=False)] == [2, 4, 2]


def test_a_case_of_the_study_is_one_line_of_json(monkeypatch):
    monkeypatch.setitem(draw.PLANS, "poor", BLINK)

    def diagnose(campaign, out):
        out.mkdir()
        (out / "verdict.json").write_text(json.dumps(said("unknown", parameters={})))

    monkeypatch.setattr(work, "diagnosed", diagnose)
    found = alike.measured("empty, poor", 5)
    assert found["outcome"] == "unknown" and found["effects"] == [] and found["times"] is None
    json.dumps(found, allow_nan=False)


def test_the_bench_has_every_run_that_a_verdict_may_propose():
    """It once had not: a case ended as open where the run that would close it could not be had."""
    recorded, things = {}, {}
    for each in draw.PLANS["poor"].conditions:
        times, angles = np.array(each.points).T
        channels = {"time": times, "reference": angles}
        recorded[each.name] = Recording(channels, {"time": "s", "reference": "rad"}, "hand")
        things[each.name] = str(each.thing)
    proposed = proposals(recorded, things)
    assert len(proposed) == 9
    for name, run in proposed.items():
        (made,) = [c for c in draw.with_run(draw.PLANS["poor"], name).runs if c.name == name]
        assert made.points[-1][0] == pytest.approx(run.time[-1], abs=2e-3)
        assert max(angle for _, angle in made.points) == pytest.approx(
            run["reference"].max(), rel=0.01
        )


def test_one_more_run_is_recorded_where_a_case_is_left_open(monkeypatch):
    plans = []

    def run_case(case, plan, seed):
        plans.append(plan)
        return {"verdict": said("named", "leader_slack" if len(plans) == 1 else "capstan")}

    monkeypatch.setattr(alike, "run_case", run_case)
    case = draw.Drawn({"leader_slack.length": 3e-3}, {"leader_slack.length": 2.0})
    next_run = {"experiment": "soft ball", "also_log": [], "separates": [], "why": ""}
    opened = {**said("unknown"), "next_run": next_run}
    assert alike.one_more(case, 7, opened) == {"suggested": "right", "any": "wrong"}
    poor = draw.PLANS["poor"].runs
    assert all(plan.runs[:-1] == poor and len(plan.runs) == 13 for plan in plans)
    assert plans[0].runs[-1].name == "soft ball" and plans[1].runs[-1].name == draw.any_run(7)
    assert not any(each.also for plan in plans for each in plan.runs)
    logged = {**said("unknown"), "next_run": {**next_run, "also_log": ["duty"]}}
    plans.clear()
    ends = alike.one_more(case, 7, logged)
    assert ends == {"suggested": "right", "any": "wrong", "same_channels": "wrong"}
    assert [plan.runs[-1].also for plan in plans] == [("duty_1",), (), ("duty_1",)]
    assert alike.one_more(case, 7, said("unknown")) == {}
    assert alike.one_more(case, 7, {**said("named", "capstan"), "next_run": next_run}) == {}


def test_the_next_run_is_worth_what_it_resolves_beyond_any_run():
    kind = plan.NAMED["single, poor"]
    ends = [{"suggested": "right", "any": "unknown"}] * 3 + [{"suggested": "right", "any": "right"}]
    done = [line(kind, k, "unknown", verdict="unknown", after=end) for k, end in enumerate(ends)]
    row = shown(done)["resolved by the suggested run rather than any [points]"]
    assert row["value"] == 75.0 and row["holds"]
    after = {"suggested": "right", "any": "unknown", "same_channels": "right"}
    again = [line(kind, 9, "unknown", verdict="unknown", after=after)]
    found = {each["study"]: each for each in summary.next_run(again) if "study" in each}
    assert found["the same, any run with the suggestion's channels [points]"]["value"] == 0.0
    rows, _ = summary.figures([line(kind, 1, "unknown", verdict="unknown")])
    assert [row["next run proposed"] for row in rows if "next run proposed" in row] == [0]


def test_probabilities_are_held_against_what_is_so():
    rng = np.random.default_rng(0)
    cases = [
        {"what": "empty", "outcome": "silent" if rng.uniform() < p else "named", "probability": p}
        for p in rng.uniform(0.5, 1.0, 2000)
    ]
    assert [row["holds"] for row in probabilities(cases)] == [True, True]
    sure = [{**case, "probability": 1.0} for case in cases]
    assert [row["holds"] for row in probabilities(sure)] == [False, False]
    assert probabilities([{**case, "probability": None} for case in cases]) == []
