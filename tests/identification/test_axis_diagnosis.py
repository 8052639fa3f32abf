"""The thin diagnosis on an axis simulated here: what it names, measures it on, and says."""

import json

import numpy as np
import pytest
from axis_campaign import campaign

from hannes.commands.cli import main
from hannes.commands.diagnose import diagnose
from hannes.identification.holdout.effect_test import POWER_80, Trial, minimum_detectable_sizes
from hannes.identification.holdout.least_squares import Fitted
from hannes.identification.verdict import Verdict, indistinguishable
from hannes.plants.axis.plant import Axis
from hannes.plants.plant_file import load_model
from hannes.simulation.catalogue import effect


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """The diagnosis of an axis that rubs harder one way, and where it was written."""
    folder = tmp_path_factory.mktemp("rubs")
    result = diagnose(campaign(folder, ["fit", "select", "show"]), out=folder / "out")
    return result, folder / "out"


def test_the_hidden_effect_is_named_with_its_size(found):
    verdict = found[0].verdict
    assert verdict.effects == ["direction_friction"]
    size = verdict.parameters["direction_friction.viscous"]
    assert size["low"] < 0.2 < size["high"] and size["value"] == pytest.approx(0.2, rel=0.2)
    gap = verdict.gap["drive"]
    assert gap["after"] < 1.2 * gap["floor"] < gap["before"] < gap["as_given"]


def test_only_sizes_distinguishable_from_none_carry_the_reduction(found):
    """Dry friction is as hard both ways here, and the sentence says so."""
    result, out = found
    assert indistinguishable(result.verdict.parameters) == ["direction_friction.dry"]
    first, _, second = result.verdict.sentence.partition(". ")
    assert "viscous" in first and "dry" not in first
    assert second.startswith("Not distinguishable from no effect: dry")
    assert "Distinguishable from no effect" in (out / "report.html").read_text(encoding="utf-8")


def test_the_baseline_says_what_else_was_off(found):
    """The mass is 96 kg; dry friction takes up what rubs harder one way."""
    result, out = found
    rows = {row["name"]: row for row in result.verdict.baseline["parameters"]}
    mass = rows["axis.mass"]
    assert mass["low"] < 96.0 < mass["high"] and mass["nominal"] == Axis().parameters["axis.mass"]
    text = (out / "report.html").read_text(encoding="utf-8")
    assert "The baseline, refitted" in text and "no new effect is in this fit" in text


def test_gaps_on_recordings_that_were_never_fitted_are_marked_as_such(found):
    result, out = found
    assert result.verdict.gap_on == "the recordings in role show, which were never fitted"
    assert result.verdict.gap_on in (out / "report.html").read_text(encoding="utf-8")
    assert result.verdict.gap_on in result.verdict.summary()


def test_the_hand_file_beside_the_verdict_is_of_its_plant(found):
    result, out = found
    model = load_model(str(out / "hand.toml"))
    assert isinstance(model, Axis) and model.effects == result.plant.effects
    assert dict(model.parameters) == dict(result.plant.parameters)


def test_gaps_on_recordings_that_were_fitted_are_marked_as_such(tmp_path, capsys):
    file = campaign(tmp_path, ["fit"])
    asked = ["diagnose", str(file), "--out", str(tmp_path / "out"), "--describe", "--json"]
    assert main(asked) == 0
    written = json.loads(capsys.readouterr().out)
    assert "nothing is to be described: the verdict is undecided" in written["cautions"]
    assert (written["verdict"], written["recordings"]["show"]) == ("undecided", [])
    assert "role show" not in written["gap_on"] and "were fitted" in written["gap_on"]
    assert written["gap_on"] in written["reason"]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert written["gap_on"] in page and "never fitted" not in page


def test_show_recordings_alone_are_fitted_and_it_is_said(tmp_path):
    verdict = diagnose(campaign(tmp_path, ["show"])).verdict
    assert verdict.verdict == "undecided" and "which were fitted too" in verdict.gap_on


def test_nothing_is_named_where_nothing_is_missing(tmp_path):
    verdict = diagnose(campaign(tmp_path, ["fit", "select", "show"], viscous=0.0)).verdict
    assert verdict.effects == [] and verdict.verdict in ("no_gap", "recalibrated")


def trial(name, deviation):
    """A trial of an effect whose amplitudes are fitted with this deviation."""
    on = effect(name)
    names = tuple(on.full_name(each.name) for each in on.amplitudes)
    size, empty = len(names), np.zeros(0)
    covariance = deviation**2 * np.eye(size)
    fitted = Fitted(Axis(), names, dict.fromkeys(names, 0.0), empty, covariance, empty, empty)
    return Trial(name, on, fitted=fitted)


@pytest.mark.parametrize(
    ("name", "amplitude", "largest"),
    [
        ("leader_slack", "length", 0.02),
        ("direction_friction", "viscous", 0.9),
        ("gear_load", "coefficient", 0.5),
    ],
)
def test_no_size_beyond_the_physical_bounds_counts_as_detectable(name, amplitude, largest):
    inside = minimum_detectable_sizes([trial(name, 0.99 * largest / POWER_80)])[name][amplitude]
    assert inside["value"] == pytest.approx(0.99 * largest) and "reason" not in inside
    beyond = minimum_detectable_sizes([trial(name, 1.01 * largest / POWER_80)])[name][amplitude]
    assert beyond["value"] is None and f"{largest:g}" in beyond["reason"]


def verdict(kind, **changes):
    """A verdict with one named effect of two sizes."""
    size = {"value": 0.2, "unit": "1", "low": 0.1, "high": 0.3, "off": 0.0}
    gap = {"unit": "V", "as_given": 0.5, "before": 0.5, "after": 0.1, "floor": 0.1}
    parameters = {"direction_friction.dry": size, "direction_friction.viscous": dict(size)}
    fields = {"effects": ["direction_friction"], "parameters": parameters, "gap": {"drive": gap}}
    rest = {key: [] for key in ("where", "candidates", "tried")}
    return Verdict(
        kind, **{**fields, **changes}, **rest, reason="r", alpha=0.01, recordings={}, seed=0
    )


def test_an_unknown_says_no_more_than_its_probability():
    for nothing, said in ((0.2, "Something is missing"), (0.8, "It is not known whether")):
        found = verdict("unknown", effects=[], probabilities={"nothing": nothing})
        assert found.sentence.startswith(said)


def test_what_was_not_taken_is_not_called_refitted():
    gap = {"drive": {"unit": "V", "as_given": 0.5, "before": 0.5, "after": 0.1, "floor": 0.1}}
    assert "(as given -> no other values taken -> result" in verdict("named", gap=gap).summary()
    gap["drive"]["before"] = 0.4
    assert "(as given -> baseline refitted -> result" in verdict("named", gap=gap).summary()


def test_the_sentence_of_each_verdict():
    sentence = verdict("named").sentence
    assert sentence == (
        "Direction friction, dry 0.2 (0.1 to 0.3), viscous 0.2 (0.1 to 0.3), "
        "explains 100 % of the reducible gap."
    )
    sizes = {
        f"{name}.size": {"value": 2.0, "unit": "1", "low": 1.9, "high": 2.1, "off": 0.0}
        for name in ("gear_load", "leader_slack")
    }
    both = verdict("named", effects=["gear_load", "leader_slack"], parameters=sizes).sentence
    assert both.startswith(
        "Gear load, size 2 (1.9 to 2.1) and leader slack, size 2 (1.9 to 2.1), ex"
    )
    assert "nothing that shows here is missing" in verdict("recalibrated", effects=[]).sentence
    near = {"drive": {"unit": "V", "as_given": 0.5, "before": 0.105, "after": 0.1, "floor": 0.1}}
    assert verdict("named", gap=near).sentence.endswith("it is less than what repeats differ by.")
    alike = {"drive": {"unit": "V", "as_given": 0.5, "before": 0.5, "after": 0.5, "floor": 0.1}}
    assert "those not fitted do not show it" in verdict("named", gap=alike).sentence
    close = {"value": 0.15, "unit": "1", "low": 0.14998, "high": 0.15003, "off": 0.0}
    narrow = verdict("named", parameters={"direction_friction.dry": close}).sentence
    assert "dry 0.15 (0.14998 to 0.15003)" in narrow
    classed = verdict("one_of", effects=["leader_slack", "mine.py:gear_load"]).sentence
    assert classed.startswith("One effect is missing, leader slack or gear load")


def test_sizes_indistinguishable_from_none_are_all_shown():
    size = {"value": 0.2, "unit": "1", "low": -0.1, "high": 0.3, "off": 0.0}
    sentence = verdict("named", parameters={"direction_friction.dry": size}).sentence
    assert sentence.count("dry 0.2 (-0.1 to 0.3)") == 2
    assert "Not distinguishable from no effect: dry" in sentence
