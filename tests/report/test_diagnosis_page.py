"""The page of a diagnosis: what stands on it, in which order, on the screen and on paper."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from browser import browser, opened

from hannes import Hand, Recording
from hannes.campaigns.campaign import Campaign, Entry
from hannes.identification.next_step import APART, OTHERS, STEPS, next_steps
from hannes.identification.residuals import Traces
from hannes.identification.verdict import SENTENCES, Verdict
from hannes.plants.hand.plant import HandPlant
from hannes.report.diagnosis import page
from hannes.report.figure_diagnosis import drawn_recording
from hannes.report.residual_map import MOST_ROWS, constant_part, residual_map
from hannes.report.schematic import STYLE

FLOORS = {"current": 0.01, "supply": 0.02}
TIME = np.linspace(0.0, 1.0, 101)
WAVE = np.where(np.arange(101) % 2, 1.0, -1.0)


def traces(name, condition, before, after):
    """One recording; `before` and `after` are residuals by channel."""
    reference = 9.0 * np.sin(np.pi * TIME)
    measured = {"current": np.sin(TIME), "supply": np.full(101, 12.0)}
    recording = Recording(
        {"time": TIME, "reference": reference, **measured},
        {"time": "s", "reference": "rad", "current": "A", "supply": "V"},
    )
    stages = [{n: measured[n] + left[n] for n in measured} for left in (before, before, after)]
    return Traces(
        Entry(name, recording, condition, "show"), TIME, np.ones(101, bool), measured, *stages
    )


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory):
    """Slack that was found; afterwards the supply is still off by a constant."""
    left = {"current": 0.08 * WAVE, "supply": np.full(101, 0.05)}
    gone = {"current": 0.004 * WAVE, "supply": np.full(101, 0.05)}
    plant = HandPlant(Hand(["leader_slack"]).with_values({"leader_slack.length": 3.1e-3}))
    drawn = tuple(traces(f"run_{k}.csv", ("void", "grasp")[k], left, gone) for k in range(2))
    gap = {
        "current": {"unit": "A", "as_given": 0.09, "before": 0.057, "after": 0.003, "floor": 0.01},
        "supply": {"unit": "V", "as_given": 0.05, "before": 0.05, "after": 0.05, "floor": 0.02},
    }
    for each in gap.values():
        each |= {f"{key}_percent": 10.0 for key in ("as_given", "before", "after")}
    size = {"value": 3.1e-3, "unit": "m", "low": 2.9e-3, "high": 3.3e-3, "off": 0.0}
    rows = [
        {"effect": name, "evidence": 9.0 - k, "gain_select": 0.9 / (1 + k), "confusable_with": []}
        for k, name in enumerate(("leader_slack", "gear_load"))
    ]
    tried = [
        {"effect": row["effect"], "applicable": True, "accepted": k == 0, "why": "accepted"}
        for k, row in enumerate(rows)
    ]
    where = [{"channel": "current", "phase": "closing", "t0": 0.0, "t1": 0.5, "rms": 0.06,
              "times_floor": 6.0, "recordings": ["run_0.csv"]}]  # fmt: skip
    least = {"leader_slack": {"length": {"value": 1e-4, "unit": "m"}},
             "gear_load": {"share": {"value": 0.0084, "unit": "1"}}}  # fmt: skip
    verdict = Verdict(
        "named", ["leader_slack"], {"leader_slack.length": size}, gap, where, rows,
        "it explains it", tried, 0.01, {"fit": ["a.csv"], "show": ["run_0.csv"]}, 1,
        "the test recordings", "repeats", smallest_detectable=least,
    )  # fmt: skip
    campaign = Campaign(
        plant, plant, tuple(t.entry for t in drawn), tmp_path_factory.mktemp("out"), {}, "Closures"
    )
    return SimpleNamespace(
        campaign=campaign, verdict=verdict, plant=plant, traces=drawn, noise_floors=FLOORS,
        trials=(), details=None,
    )  # fmt: skip


def test_page_has_in_order_what_it_is_what_it_does_where_and_who_else(diagnosis):
    text = page(diagnosis)
    marks = (
        "Leader slack, length 3.1 mm (2.9 to 3.3)",  # the sentence
        "it disagrees most in current, closing: 6 times the noise floor",
        "What to do",
        "<li>Simulate with this result",
        "The leader wire has come loose",
        "s_L = r_p th/N - length",
        'id="schematic"',
        "Before and after",
        '<h2 id="where">',
        "Rivals",
    )
    places = [text.index(each) for each in marks]
    assert places == sorted(places)
    assert 'class="leader marked"' in text
    assert "3.1 mm (2.9 to 3.3)</td>" in text  # the table's unit is the sentence's


def test_the_page_says_what_the_residual_goes_with(diagnosis):
    said = {
        "baseline": {"sentence": "In contact alone; grows with load.", "statements": []},
        "left": {"sentence": "", "statements": []},
    }
    verdict = replace(diagnosis.verdict, goes_with=said)
    text = page(SimpleNamespace(**{**vars(diagnosis), "verdict": verdict}))
    assert "What is left without any new effect: in contact alone; grows with load." in text
    assert "What is left beside" not in text and "What is left beside" not in verdict.summary()
    said["left"]["sentence"] = "While opening alone."
    assert "What is left beside leader slack: while opening alone." in verdict.summary()
    said["left"] = {"sentence": "", "statements": [], "tested": True}
    classed = replace(verdict, verdict="one_of", effects=["leader_slack", "gear_load"])
    assert "beside leader slack or gear load: nothing that repeats share" in classed.summary()


def test_what_is_left_is_said_in_words(diagnosis):
    text = page(diagnosis)
    assert "below the noise floor: no more than repeats differ by" in text
    assert "nearly all of it a constant, 0.0500 V: check that sensor" in text


def test_a_constant_that_is_most_of_what_is_left_is_said(diagnosis):
    """A supply that is off by a constant and sags besides."""
    sag = {"current": 0.004 * WAVE, "supply": 0.05 + 0.04 * WAVE}
    drawn = tuple(traces(f"run_{k}.csv", "void", sag, sag) for k in range(2))
    gap = {**diagnosis.verdict.gap}
    gap["supply"] = {**gap["supply"], "after": 0.064}
    verdict = replace(diagnosis.verdict, gap=gap)
    text = page(SimpleNamespace(**{**vars(diagnosis), "traces": drawn, "verdict": verdict}))
    constant = 0.05 + 0.04 * WAVE.mean()
    assert f"most of it a constant, {constant:.3g} V: check that sensor" in text


def test_a_channel_that_is_off_in_some_phases_alone_has_no_wrong_zero(diagnosis):
    moving = np.where(np.arange(101) < 30, 0.0, 0.05)
    off = {"current": 0.004 * WAVE, "supply": moving}
    drawn = tuple(traces(f"run_{k}.csv", "void", off, off) for k in range(2))
    gap = {**diagnosis.verdict.gap}
    gap["supply"] = {**gap["supply"], "after": 0.042}
    verdict = replace(diagnosis.verdict, gap=gap)
    changed = SimpleNamespace(**{**vars(diagnosis), "traces": drawn, "verdict": verdict})
    phases = {"start": np.arange(101) < 30, "closing": np.arange(101) >= 30}
    changed.plant = SimpleNamespace(phases=lambda recording: phases)
    assert constant_part(changed, "supply") == 0.0
    phases["start"], phases["closing"] = phases["start"] & False, phases["closing"] | True
    assert constant_part(changed, "supply") == pytest.approx(moving.mean())


def test_the_recording_that_is_furthest_off_is_drawn(diagnosis):
    drawn = tuple(
        traces(name, "void", off := {"current": size * WAVE, "supply": 0.0 * WAVE}, off)
        for name, size in (("little.csv", 0.01), ("much.csv", 0.5), ("less.csv", 0.1))
    )
    changed = SimpleNamespace(**{**vars(diagnosis), "traces": drawn})
    assert drawn_recording(changed).entry.name == "much.csv"


def test_what_was_tried_has_the_units_of_the_sentence(diagnosis):
    text = page(diagnosis)
    assert "length 0.10 mm" in text and "10⁻⁴" not in text
    assert "share 0.0084" in text and "a number without a unit is a ratio" in text


def test_map_shows_condition_and_phase_before_and_after(diagnosis):
    found = residual_map(diagnosis)
    assert found.channels == ("current", "supply") and found.recordings == 2
    assert {row[0] for row in found.rows} == {"void", "grasp"}
    for _, _, (current, supply) in found.rows:
        before, after = (float(x) for x in current.text.split(" → "))
        assert before > 3.0 > 1.0 > after and current.shade >= 2
        assert supply.text == "2.5 → 2.5" and supply.shade == 1


def test_map_of_many_conditions_shows_those_furthest_off(diagnosis):
    many = [
        traces(
            f"run_{k}.csv", f"load {k}", *[{"current": 0.1 * k * WAVE, "supply": 0.0 * WAVE}] * 2
        )
        for k in range(1, MOST_ROWS + 6)
    ]
    found = residual_map(SimpleNamespace(**{**vars(diagnosis), "traces": many}))
    assert len(found.rows) == MOST_ROWS and found.left_out >= 5
    assert found.rows[-1][0] == f"load {MOST_ROWS + 5}" and "load 1" not in {
        r[0] for r in found.rows
    }


def test_without_an_effect_there_is_no_section_of_one(diagnosis):
    verdict = replace(diagnosis.verdict, verdict="unknown", effects=[], parameters={})
    text = page(SimpleNamespace(**{**vars(diagnosis), "verdict": verdict}))
    assert 'id="effect"' not in text and 'id="schematic"' not in text
    assert "Something is missing" in text and "Where it disagreed" in text
    assert "<li>Add no effect yet." in text


def test_every_verdict_says_what_to_do():
    assert STEPS.keys() == SENTENCES.keys() and all(STEPS.values())


def test_the_run_worth_recording_is_the_step_that_records():
    for verdict, general in (("one_of", APART), ("unknown", OTHERS)):
        steps, advised = next_steps(verdict, ""), next_steps(verdict, "Record next: a ball.")
        place = steps.index(general)
        assert advised[place] == "Record next: a ball." and general not in advised
        assert steps[:place] + steps[place + 1 :] == advised[:place] + advised[place + 1 :]
    assert next_steps("named", "Record next: a ball.") == next_steps("named", "")


def test_the_schematic_restyles_no_other_drawing():
    rules = [each for each in STYLE.split("}") if each]
    assert all(
        part.startswith(".schematic") for each in rules for part in each.split("{")[0].split(",")
    )


def test_page_prints_without_cut_tables(diagnosis, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(page(diagnosis), encoding="utf-8")
    with browser() as running:
        narrow, messages = opened(running, path, 600, 900)
        assert narrow.evaluate("document.documentElement.scrollWidth") <= 600
        cells = "[...document.querySelectorAll('#tried td')]"
        assert max(narrow.evaluate(f"{cells}.map((x) => x.getBoundingClientRect().right)")) <= 600
        sheet, more = opened(running, path, 688, 1000)  # A4 less its margins, at 96 dots an inch
        sheet.emulate_media(media="print")
        every = "[...document.querySelectorAll('table, svg')]"
        rights = f"{every}.map((each) => each.getBoundingClientRect().right)"
        assert max(sheet.evaluate(rights)) <= 690
        broken = sheet.evaluate(
            "getComputedStyle(document.querySelector('#tried th')).overflowWrap"
        )
        assert broken == "break-word"  # `anywhere` cuts words to make room for others
        assert messages + more == []


def test_the_page_says_of_which_machine_the_gaps_before_are(diagnosis):
    """A refit that is not taken is no baseline; as given, nothing comes after it."""

    def shown(kind, before, **fields):
        gap = {
            n: each | {"as_given": 0.5, "before": before}
            for n, each in diagnosis.verdict.gap.items()
        }
        verdict = replace(diagnosis.verdict, verdict=kind, gap=gap, **fields)
        return page(SimpleNamespace(**vars(diagnosis) | {"verdict": verdict}))

    text = shown("unknown", 0.5, effects=[], parameters={})
    assert "in noise floors, as given" in text and "After is the machine as given" in text
    text = shown("unknown", 0.4, effects=[], parameters={})
    assert "with the baseline refitted" in text and "After is the machine refitted" in text
    assert "After is the machine as given" in shown("no_gap", 0.4, effects=[], parameters={})
    assert "as given → with the effect" in shown("named", 0.5)
