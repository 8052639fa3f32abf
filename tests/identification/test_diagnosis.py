"""The deep diagnosis on a machine simulated here: what it names and what it refuses."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sled import (
    GUST,
    HARDENING,
    KNOWN,
    RATTLE,
    TIMES,
    TURBULENCE,
    TWIN,
    UNITS,
    Sled,
    campaign,
    effect,
    found,
    nearly_turbulence,
    recordings,
    suction,
)

from hannes.campaigns.campaign import Campaign, Entry
from hannes.commands.diagnose import diagnose
from hannes.core.effect import Term
from hannes.core.parameter import Parameter
from hannes.core.recording.recording import Recording
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.further_effects import with_further_effects
from hannes.identification.diagnosis.gauss_newton import fitted
from hannes.identification.diagnosis.multistart import started_at_guess
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.trials import Trial


@pytest.mark.parametrize(("hidden", "size"), [(HARDENING, 900.0), (TURBULENCE, 2.0)])
def test_a_hidden_effect_is_named_with_its_size(hidden, size):
    verdict = found(1, ((hidden, size),))
    assert (verdict.verdict, verdict.effects) == ("named", [hidden.name])
    size_found = verdict.parameters[f"{hidden.name}.size"]
    assert size_found["value"] == pytest.approx(size, rel=0.1)
    assert size_found["low"] < size < size_found["high"]
    for gap in verdict.gap.values():
        assert gap["after"] < 1.2 * gap["floor"] and gap["after"] < gap["before"]


@pytest.mark.parametrize("seed", range(2, 8))
def test_nothing_is_named_on_a_machine_that_only_has_other_parameters(seed):
    verdict = found(seed)
    assert (verdict.verdict, verdict.effects) == ("recalibrated", [])


def test_a_machine_as_given_has_no_gap():
    entries = recordings(2)
    exact = Sled()
    made = []
    for k, entry in enumerate(entries):
        rng = np.random.default_rng([9, k])
        run = exact.simulate({}, entry.recording)
        noisy = {
            name: values + 2e-3 * rng.standard_normal(TIMES.size) for name, values in run.items()
        }
        recording = Recording({**entry.recording.channels, "time": TIMES, **noisy}, UNITS)
        made.append(Entry(entry.name, recording, entry.condition, entry.role))
    verdict = diagnose(
        Campaign(exact, exact, tuple(made), Path("out"), KNOWN), progress=False
    ).verdict
    assert verdict.verdict == "no_gap"


@pytest.mark.slow
def test_two_effects_are_both_named():
    verdict = found(3, ((HARDENING, 900.0), (TURBULENCE, 2.0)))
    assert verdict.verdict == "named" and sorted(verdict.effects) == ["hardening", "turbulence"]


def test_a_first_effect_that_only_led_to_the_second_is_dropped():
    """Else a wrong name would stay beside the right one."""
    said = campaign(1, ((TURBULENCE, 2.0),))
    whole = search_effects(
        said.plant, said.of("fit", "select"), list(KNOWN.values()), Settings(), 0
    )
    guess = next(each for each in whole.guesses if each.effect == "hardening")
    wrong = Trial(("hardening",), fitted(started_at_guess(whole.baseline, guess), 5), 1e3)
    again = with_further_effects(replace(whole, trials=[wrong]), 0, lambda text: None)
    assert again.trials[0].effects == ("turbulence",) and again.joint is None
    assert again.trials[0].delta_chi2 == pytest.approx(whole.trials[0].delta_chi2, rel=1e-3)


def test_what_no_effect_explains_is_unknown():
    verdict = found(4, ((GUST, 1.0),))
    assert (verdict.verdict, verdict.effects) == ("unknown", [])
    assert "per bin" in verdict.reason


def test_effects_that_do_the_same_make_a_class():
    known = {each.name: each for each in (HARDENING, TURBULENCE, TWIN)}
    verdict = found(5, ((TURBULENCE, 2.0),), known)
    assert verdict.verdict == "one_of" and sorted(verdict.effects) == ["turbulence", "twin"]
    alike = {row["effect"]: row["confusable_with"] for row in verdict.candidates}
    assert alike["turbulence"] == ["twin"] and alike["twin"] == ["turbulence"]
    for row in verdict.candidates[:2]:  # each as large as it would be, were it the one
        assert row["sizes"]["size"]["value"] == pytest.approx(2.0, rel=0.1)
    assert "turbulence (size " in verdict.sentence and "twin (size " in verdict.sentence


def test_what_leaves_much_in_one_place_is_not_named():
    """Of two effects one has a twin: the other alone would leave 48 times the noise floor."""
    known = {each.name: each for each in (HARDENING, TURBULENCE, TWIN)}
    verdict = found(3, ((HARDENING, 900.0), (TURBULENCE, 2.0)), known)
    assert (verdict.verdict, verdict.effects) == ("unknown", [])
    assert "lowers it nearly as much" in verdict.reason
    assert "times the noise floor in the speed, run of slow" in verdict.reason


def test_an_effect_that_is_off_at_its_upper_bound_is_tried():
    size = Parameter("size", 0.0, "N s^2/m^2", (-30.0, 0.0), "how much", off=0.0)
    wake = replace(TURBULENCE, name="wake", parameters=(size,), terms=(Term(suction, ("force",)),))
    verdict = found(1, ((TURBULENCE, 2.0),), {"hardening": HARDENING, "wake": wake})
    assert (verdict.verdict, verdict.effects) == ("named", ["wake"])


def test_the_next_run_is_the_one_that_separates_two_explanations(tmp_path):
    nearly = effect("nearly", nearly_turbulence, 30.0, "N s^2/m^2")
    known = {"nearly": nearly, "turbulence": TURBULENCE}
    out = tmp_path / "out"
    verdict = diagnose(campaign(5, ((TURBULENCE, 2.0),), known), out=out, progress=False).verdict
    assert verdict.verdict == "one_of"
    assert f". Record next: {RATTLE}; it would separate " in verdict.summary()
    assert verdict.advice in (out / "report.html").read_text(encoding="utf-8")
    assert verdict.next_run["experiment"] == RATTLE
    assert sorted(verdict.next_run["separates"]) == ["nearly", "turbulence"]
    assert "standard deviations" in verdict.next_run["why"]


def test_no_next_run_where_one_effect_is_named():
    assert found(1, ((HARDENING, 900.0),)).next_run is None


def test_confusable_effects_are_listed_and_shown(tmp_path):
    known = {each.name: each for each in (HARDENING, TURBULENCE, TWIN)}
    result = diagnose(
        campaign(5, ((TURBULENCE, 2.0),), known), out=tmp_path / "out", progress=False
    )
    table = result.verdict.confusability
    cosine = dict(zip(table["effects"], table["cosines"], strict=True))
    place = {name: k for k, name in enumerate(table["effects"])}
    assert cosine["twin"][place["turbulence"]] == pytest.approx(1.0, abs=2e-3)
    assert cosine["twin"][place["hardening"]] < 0.95
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Confusable effects" in page and "<script" not in page


def test_show_recordings_change_nothing_but_the_gaps_and_may_withdraw_a_name():
    whole = campaign(1, ((HARDENING, 900.0),))
    spoilt = tuple(
        Entry(e.name, shifted(e.recording), e.condition, e.role) if e.role == "show" else e
        for e in whole.entries
    )
    one, other = (
        diagnose(
            Campaign(Sled(), Sled(), each, Path("out"), KNOWN, diagnose=whole.diagnose),
            progress=False,
        )
        for each in (whole.entries, spoilt)
    )
    assert one.verdict.candidates == other.verdict.candidates
    assert one.verdict.baseline == other.verdict.baseline or other.verdict.baseline is None
    assert one.verdict.gap != other.verdict.gap


def shifted(recording):
    """The recording with its position moved."""
    return Recording(
        {**recording.channels, "position": recording["position"] + 0.05}, recording.units
    )


def test_the_same_seed_gives_the_same_verdict():
    assert found(6).json() == found(6).json()
