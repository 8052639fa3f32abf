"""Calibration on a machine of a few lines: values, intervals, labels, what remains, bad input."""

import sys
from dataclasses import replace
from typing import ClassVar

import numpy as np
import oven
import pytest
import scipy.optimize

from hannes.campaigns.campaign import Campaign, Entry
from hannes.commands.calibrate import calibrate
from hannes.core.errors import BadInput, ComputationFailed
from hannes.core.recording.recording import Recording
from hannes.identification.calibration import least_squares, search
from hannes.identification.calibration.result import value_text
from hannes.identification.calibration.tuning import CALIBRATION
from hannes.identification.grasp_features import measure

TRUE = {"oven.gain": 2.5, "oven.time": 0.62, "oven.offset": 0.3}
THREE = list(TRUE)


def by_name(found):
    return {each.name: each for each in found.answers}


def test_values_come_back_and_all_starts_agree():
    found = calibrate(oven.campaign(1, TRUE, parameters=THREE), progress=False)
    for name, answer in by_name(found).items():
        assert answer.value == pytest.approx(TRUE[name], rel=0.02)
        assert answer.low < TRUE[name] < answer.high
        assert answer.identified
    assert found.agreeing == [True] * 4
    assert found.repeatable_residual.repeats is not True
    assert found.plant.parameters["oven.gain"] == by_name(found)["oven.gain"].value


def test_the_search_is_scipys_bounded_least_squares(monkeypatch):
    """Each round is one call, within the asked bounds; the answer is a point that it tried."""
    calls, original = [], scipy.optimize.least_squares

    def noted(residual, start, **options):
        tried = []
        calls.append((tried, options["bounds"]))

        def counted(x):
            tried.append(x.copy())
            return residual(x)

        return original(counted, start, **options)

    monkeypatch.setattr(scipy.optimize, "least_squares", noted)
    asked = {"bounds": {"oven.gain": ["0.5", "4"]}}
    made = oven.campaign(1, TRUE, parameters=THREE, starts=1, **asked)
    found = calibrate(made, progress=False).found
    assert len(calls) == len(found.costs) > 1
    for _, (low, high) in calls:
        assert np.isfinite([low, high]).all()
        assert np.array_equal([low, high], [found.scales.low, found.scales.high])
    assert any(np.array_equal(found.x, x) for x in calls[-1][0])


def coverage(plant, count, scatter, **asked):
    """Share of campaigns whose intervals hold the truth: ours, and the textbook's."""
    ours, textbook = {name: 0 for name in THREE}, {name: 0 for name in THREE}
    for seed in range(count):
        made = oven.campaign(
            seed, TRUE, plant=plant, scatter=scatter, parameters=THREE, starts=1, **asked
        )
        for answer in calibrate(made, progress=False, workers=1).answers:
            true = TRUE[answer.name]
            ours[answer.name] += answer.low <= true <= answer.high
            textbook[answer.name] += answer.textbook[0] <= true <= answer.textbook[1]
    return ours, textbook


@pytest.mark.slow
@pytest.mark.parametrize("plant", [oven.RunToRun, oven.Oven])
def test_intervals_hold_whether_or_not_the_plant_knows_how_its_runs_differ(plant):
    """Of 140 campaigns 95 % is 133 +- 2.6: bounds are three such deviations away, but not all."""
    ours, textbook = coverage(plant, 140, 0.01)
    for name, held in ours.items():
        assert 125 <= held <= 139, name
    assert textbook["oven.gain"] < 95  # the usual covariance does not know that runs differ


def test_a_wrong_spread_of_the_given_value_hardly_matters():
    narrow = calibrate(
        oven.campaign(2, TRUE, parameters=THREE, spread={"oven.gain": "20 %"}), progress=False
    )
    wide = calibrate(
        oven.campaign(2, TRUE, parameters=THREE, spread={"oven.gain": "80 %"}), progress=False
    )
    a, b = (by_name(each)["oven.gain"] for each in (narrow, wide))
    assert abs(a.value - b.value) < 0.1 * a.deviation


def test_what_shows_only_through_a_product_is_confounded_and_says_with_what():
    asked = [*THREE, "oven.resistance"]
    found = by_name(calibrate(oven.campaign(3, TRUE, parameters=asked), progress=False))
    assert found["oven.gain"].label == found["oven.resistance"].label == "confounded"
    assert found["oven.gain"].partners == ("oven.resistance",)
    assert found["oven.resistance"].partners == ("oven.gain",)
    assert found["oven.time"].identified
    product = found["oven.gain"].value * found["oven.resistance"].value
    assert product == pytest.approx(2.5 * 3.0, rel=0.02)


def test_what_shows_nowhere_is_not_identified_and_stays_where_it_was():
    asked = [*THREE, "oven.paint"]
    answer = by_name(calibrate(oven.campaign(4, TRUE, parameters=asked), progress=False))[
        "oven.paint"
    ]
    assert answer.label == "not identified" and "moves nothing" in answer.reason
    assert answer.value == pytest.approx(1.0)


def test_a_parameter_that_ends_at_its_bound_says_so():
    made = oven.campaign(5, TRUE, parameters=THREE, bounds={"oven.time": ["0.3 s", "0.55 s"]})
    answer = by_name(calibrate(made, progress=False))["oven.time"]
    assert answer.label == "at its bound" and answer.value == pytest.approx(0.55)


def test_a_parameter_that_is_zero_as_given_moves():
    made = oven.campaign(6, TRUE, parameters=["oven.offset"], powers=(0.0, 1e-9))
    answer = by_name(calibrate(made, progress=False))["oven.offset"]
    assert answer.value == pytest.approx(0.3, abs=0.01)


def test_a_model_that_lacks_an_effect_fits_better_is_biased_and_reported():
    hidden = {**TRUE, "oven.hidden": 0.15}
    found = calibrate(oven.campaign(7, hidden, parameters=THREE), progress=False)
    assert found.fitted_gap["heat"]["after"] < 0.5 * found.fitted_gap["heat"]["as_given"]
    gain = by_name(found)["oven.gain"]
    assert not gain.low <= TRUE["oven.gain"] <= gain.high
    assert found.repeatable_residual.repeats is True
    assert "hannes diagnose" in found.repeatable_residual.sentence


def test_runs_never_fitted_are_predicted_down_to_the_floor():
    found = calibrate(oven.campaign(8, TRUE, runs=10, shown=3, parameters=THREE), progress=False)
    for gap in found.gap.values():
        assert gap["after"] < 0.2 * gap["as_given"]
        assert gap["after"] < 2.0 * gap["floor"]


def test_test_runs_alone_are_fitted_and_not_reported_as_held_out():
    made = oven.campaign(8, TRUE, runs=6, shown=6, parameters=THREE)
    found = calibrate(made, progress=False)
    assert found.gap == {} and set(found.fitted_gap) == {"heat", "glow"}


def test_run_to_run_variability_about_zero_is_printed_in_its_unit(tmp_path):
    asked = {"parameters": ["oven.gain"], "nuisance": {"oven.offset": "1 mm"}}
    made = oven.campaign(8, TRUE, runs=6, **asked)
    calibrate(made, out=tmp_path / "out", progress=False)
    assert "oven.offset" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("unit", "shown"),
    [("m", "0.500 mm (0.400 to 0.600)"), ("m^2", "0.000500 m^2 (0.000400 to 0.000600)")],
)
def test_thousandths_are_printed_of_plain_units_alone(unit, shown):
    found = calibrate(oven.campaign(1, TRUE, parameters=["oven.gain"]), progress=False)
    answer = replace(found.answers[0], unit=unit, value=5e-4, low=4e-4, high=6e-4)
    assert value_text(answer) == shown


def test_one_run_alone_is_cut_into_segments_and_says_so():
    found = calibrate(oven.campaign(9, TRUE, runs=1, parameters=["oven.gain"]), progress=False)
    assert found.spread.unit == "segments of one run"
    assert found.repeatable_residual.repeats is None
    assert by_name(found)["oven.gain"].value == pytest.approx(2.5, rel=0.1)


class Door(oven.Oven):
    """An oven's door: it closes to a known law, and one run is slower than the next."""

    channels: ClassVar = {"time": "s", "power": "V", "position": "rad"}
    judged = ("position",)

    def simulate(self, parameters, recording):
        """Closed form."""
        p = self.parameters.with_values(parameters)
        shut = 1.0 - np.exp(-recording.time / p["oven.time"])
        return {"position": p["oven.gain"] * shut}


def doors(time, runs=8, noise=0.002, **asked):
    """A campaign of doors, of which only `oven.time` differs from what is given."""
    rng, entries = np.random.default_rng(1), []
    blank = oven.run(rng, {}).between(0.0, 2.0)
    for k in range(runs):
        own = {"oven.time": time * (1.0 + 0.01 * rng.standard_normal())}
        seen = Door().simulate(own, blank)["position"]
        channels = {"time": blank.time, "power": blank["power"]}
        channels["position"] = seen + noise * rng.standard_normal(seen.size)
        entries.append(Entry(f"run {k}", Recording(channels, Door.channels), "shut", "fit"))
    table = oven.Table(asked, "oven.toml", ())
    return Campaign(Door(), Door(), tuple(entries), None, {}, "door", calibrate=table)


def test_features_alone_do_and_a_scan_finds_the_way():
    asked = {"parameters": ["oven.time"], "channels": [], "features": ["closing time"]}
    found = calibrate(doors(0.62, scan=32, **asked), progress=False)
    (answer,) = found.answers
    assert answer.value == pytest.approx(0.62, rel=0.02)
    assert answer.low < 0.62 < answer.high and answer.identified
    assert found.found.plan.scan == 32 and found.fitted_gap == {}


def test_features_without_sense_are_left_out():
    time = np.arange(0.0, 1.0, 1e-3)
    closing = measure(("closing time",), time, {"position": np.clip(10.0 * time, 0.0, 8.0)})
    assert closing[0] == pytest.approx(0.72, abs=1e-9)
    touching = {"position": time, "force": 5.0 * time}
    assert np.isnan(measure(("closing time", "void current"), time, touching)).all()


def test_a_lopsided_interval_is_had_by_profile():
    """Far from shut after two seconds, the door shows its speed: the inverse of what is asked."""
    spread = {"oven.time": "200 %"}
    asked = {"parameters": ["oven.time"], "spread": spread, "starts": 1}
    (answer,) = calibrate(doors(2.5, noise=2.0, **asked), progress=False).answers
    assert answer.skewed
    assert answer.high - answer.value > 1.2 * (answer.value - answer.low) > 0.0
    assert answer.low < 2.5 < answer.high


def test_the_number_of_workers_changes_no_digit():
    made = oven.campaign(10, TRUE, parameters=THREE)
    one, two = (calibrate(made, progress=False, workers=n).json() for n in (1, 3))
    assert one == two


def test_an_interrupted_search_gives_the_best_so_far(monkeypatch):
    solve, done = search.solve, []

    def interrupted(*arguments):
        if done:
            raise KeyboardInterrupt
        done.append(solve(*arguments))
        return done[0]

    monkeypatch.setattr(search, "solve", interrupted)
    made = oven.campaign(11, TRUE, parameters=THREE, starts=1)
    found = calibrate(made, progress=False)
    assert found.found.interrupted and found.sentence.startswith("Interrupted")
    assert found.plain()["status"] == "interrupted"
    assert by_name(found)["oven.gain"].value == pytest.approx(2.5, rel=0.2)


@pytest.mark.parametrize("part", ["sides", "prediction"])
def test_interrupted_during_its_intervals_the_fit_is_kept(monkeypatch, tmp_path, part):
    made = oven.campaign(18, TRUE, parameters=THREE, shown=2)
    whole = by_name(calibrate(made, progress=False))

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(sys.modules["hannes.commands.calibrate"], part, interrupted)
    found = calibrate(made, out=tmp_path / "out", progress=False)
    assert found.plain()["status"] == "interrupted" and found.gap == found.fitted_gap == {}
    for name, answer in by_name(found).items():
        assert answer.value == whole[name].value
        assert answer.low < TRUE[name] < answer.high
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Interrupted before any recording was predicted" in page


def test_a_robust_loss_survives_a_spoilt_stretch():
    made = oven.campaign(12, TRUE, parameters=THREE)
    spoilt = made.entries[0].recording
    bad = spoilt["heat"].copy()
    bad[50:90] += 10.0 * np.sin(np.linspace(0.0, np.pi, 40)) ** 2  # no step: those are refused
    entry = replace(made.entries[0], recording=spoilt.with_channels({"heat": bad}, {}))
    made = replace(made, entries=(entry, *made.entries[1:]))
    robust_plan = replace(
        made, calibrate=oven.Table({"parameters": THREE, "loss": "cauchy"}, "", ())
    )
    plain, robust = (
        by_name(calibrate(each, progress=False))["oven.gain"] for each in (made, robust_plan)
    )
    assert abs(robust.value - 2.5) < 0.5 * abs(plain.value - 2.5)
    assert robust.value == pytest.approx(2.5, rel=0.02)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"parameters": ["oven.gane"]}, 'did you mean "oven.gain"'),
        ({"parameters": []}, "names none"),
        ({"parameters": THREE, "loss": "sotf_l1"}, 'did you mean "soft_l1"'),
        ({"parameters": THREE, "channels": ["haet"]}, 'did you mean "heat"'),
        ({"parameters": THREE, "features": ["closing tim"]}, 'did you mean "closing time"'),
        ({"parameters": THREE, "spread": {"oven.time": "3 m"}}, "is not a time"),
        ({"parameters": THREE, "spread": {"oven.paint": "3 %"}}, "no parameter of this"),
        ({"parameters": THREE, "bounds": {"oven.time": ["2 s", "1 s"]}}, "two rising values"),
        ({"parameters": THREE, "nuisance": {"start_time": "-1 s"}}, "not negative"),
        ({"parameters": THREE, "starts": 0}, "whole number"),
        ({"parameters": THREE, "limit": "200 %"}, "between 0 and 100"),
    ],
)
def test_a_fault_in_what_is_asked_is_one_line(asked, said):
    with pytest.raises(BadInput, match=r"oven\.toml") as caught:
        calibrate(oven.campaign(13, TRUE, **asked), progress=False)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_more_parameters_than_the_recordings_bear_are_refused():
    asked = [
        "oven.gain",
        "oven.time",
        "oven.offset",
        "oven.paint",
        "oven.hidden",
        "oven.resistance",
    ]
    with pytest.raises(BadInput, match="6 parameters are more than 1 recordings"):
        calibrate(oven.campaign(14, TRUE, runs=1, parameters=asked), progress=False)


def test_a_machine_that_cannot_be_simulated_as_given_is_a_failed_computation():
    made = oven.campaign(15, TRUE, parameters=THREE)
    burning = replace(made, plant=oven.Oven().with_values({"oven.time": 0.06}))
    with pytest.raises(ComputationFailed, match="flames") as caught:
        calibrate(burning, progress=False)
    assert "try" in str(caught.value) and caught.value.exit_status == 3


def test_a_search_that_does_not_settle_is_a_failed_computation(monkeypatch):
    few = replace(CALIBRATION, max_evaluations=2, max_rounds=2)
    monkeypatch.setattr(least_squares, "CALIBRATION", few)
    monkeypatch.setattr(search, "CALIBRATION", few)
    far = {"oven.gain": 9.0, "oven.time": 3.0, "oven.offset": 4.0}
    with pytest.raises(ComputationFailed, match="did not converge"):
        calibrate(oven.campaign(16, far, parameters=THREE), progress=False)


def test_results_are_written_whole(tmp_path):
    import json

    out = tmp_path / "out"
    made = oven.campaign(17, TRUE, parameters=THREE, shown=2)
    found = calibrate(made, out=out, progress=False)
    written = json.loads((out / "calibration.json").read_text(encoding="utf-8"))
    assert written["parameters"]["oven.gain"]["value"] == by_name(found)["oven.gain"].value
    assert written["status"] == "converged"
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "oven.gain" in page and "<script" not in page and 'src="http' not in page
    assert "oven.gain" in (out / "hand.toml").read_text(encoding="utf-8")
