"""Recognition: causal features, trees as plain arrays that equal scikit-learn's, checked files."""

import json
import re
import time
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from sklearn.model_selection import GridSearchCV
from sklearn.pipeline import Pipeline

from hannes.bench.events import About, Row
from hannes.bench.live import LiveRecogniser
from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.dataset.make import make
from hannes.dataset.read import read
from hannes.dataset.spec import read_spec
from hannes.recognition import hysteresis_features, model_file
from hannes.recognition import train as learning
from hannes.recognition.estimators import BaggedTrees, WindowFeatures
from hannes.recognition.features import CHANNELS, NAMES
from hannes.recognition.train import train
from hannes.recognition.windowing import Windowing

TEXT = """
title = "some grasps"
seed = 7
duration = "1.15 s"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.637 s", "9.84 rad"], ["1.022 s", "0 rad"]]
[values]
"motor.dry_friction" = { spread = "0.05" }
"noise.current" = "10 mA"
"object.stiffness" = ["800 N/m", "2 kN/m", "15 kN/m", "38.3 kN/m"]
[[grasps]]
name = "cylinders"
shape = "cylinder"
draws = 20
[grasps.values]
"object.radius" = { uniform = ["18 mm", "30 mm"] }
[[grasps]]
name = "held back"
shape = "cylinder"
role = "test"
draws = 5
[grasps.values]
"object.radius" = { uniform = ["18 mm", "30 mm"] }
"""


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """A data set of a hundred grasps."""
    path = tmp_path_factory.mktemp("data") / "set.h5"
    make(read_spec(TEXT), path, workers=1, progress=False)
    return path


@pytest.fixture(scope="module")
def trained(data):
    """A small model, and the scores of its training."""
    return train(data, trees=12, seed=1, jobs=1)


def test_larger_leaves_make_smaller_trees_of_single_precision(data, trained):
    small, _ = train(data, trees=12, seed=1, jobs=1, leaf=8)
    for name in ("rigid", "stiffness", "force"):
        forest = getattr(small, name)
        assert forest.value.size < getattr(trained[0], name).value.size
        assert np.array_equal(forest.value, forest.value.astype(np.float32))


@pytest.fixture(scope="module")
def arrays(data):
    """Grasps as arrays (n, samples, 3), their classes, and a recording of one."""
    found = read(data)
    (block,) = found.blocks(np.arange(100), (*CHANNELS, "force"))
    return block, found.rigid.astype(int), found.time


def recording(arrays, k, **changed):
    """Grasp k as a recording."""
    block, _, times = arrays
    named = dict(zip((*CHANNELS, "force"), block[k].astype(float).T, strict=True))
    units = {"time": "s", "current": "A", "position": "rad", "reference": "rad", "force": "N"}
    return Recording({"time": times, **named, **changed}, units)


def seen_until(grasp, end):
    """The first samples of a recording."""
    return Recording({name: x[:end] for name, x in grasp.channels.items()}, grasp.units)


def test_features_do_not_know_what_comes_after(arrays):
    cut, block = Windowing(), arrays[0][..., :3]
    whole = cut.features(block[:8])
    for seen in (150, 420, 777):
        part = cut.features(block[:8, :seen])
        assert np.array_equal(part, whole[:, : part.shape[1]])
    changed = block[:8].copy()
    changed[:, 600:] += 1.0
    before = cut.ends(block.shape[1]) <= 600
    assert np.array_equal(cut.features(changed)[:, before], whole[:, before])


def test_features_are_what_their_names_say():
    time = np.arange(1000) / 1000.0
    position = 10.0 * time
    touch = position[400]
    current = np.where(position < touch, 0.3, 0.3 + 0.5 * (position - touch))
    rows = Windowing().features(np.stack([current, position, 1.2 * position], axis=1)[np.newaxis])[
        0
    ]
    row = dict(zip(NAMES, rows[-1], strict=True))
    assert row["speed"] == pytest.approx(10.0) and row["reference_speed"] == pytest.approx(12.0)
    assert row["free_current"] == pytest.approx(0.3, abs=1e-6)
    assert row["tangent"] == pytest.approx(0.5, rel=1e-3) == row["steepest"]
    assert row["touch_position"] == pytest.approx(touch, abs=0.15)
    assert row["rise_at_3"] == pytest.approx(0.5 * 1.0, abs=0.08)
    assert row["since"] == pytest.approx(0.6, abs=0.02)
    assert np.isfinite(rows).all()


def test_a_recording_of_another_sampling_is_understood(arrays, trained):
    model, _ = trained
    fine = recording(arrays, 70)
    coarse = Recording({n: x[::2] for n, x in fine.channels.items()}, fine.units)
    late = Recording({**fine.channels, "time": fine.time + 5.0}, fine.units)
    assert model.predict(coarse).decision == model.predict(fine).decision == "rigid"
    assert np.allclose(model.predict(late).time, model.predict(fine).time + 5.0)
    assert np.array_equal(model.predict(late).rigid, model.predict(fine).rigid)


def test_live_decisions_are_those_of_the_whole_recording(arrays, trained):
    """Sample after sample, whatever comes later: the same probabilities, bit for bit."""
    grasp, model = recording(arrays, 11), trained[0]
    live, said = LiveRecogniser(model), model.predict(grasp)
    units = {name: grasp.units[name] for name in CHANNELS}
    live.feed(About("test", units, 1000.0, 0.2))
    rows = zip(grasp.time.tolist(), *(grasp[name].tolist() for name in CHANNELS), strict=True)
    made = [
        decision
        for number, (moment, *values) in enumerate(rows)
        for decision in live.feed(Row(number, 5.0 + moment, tuple(values)))
    ]
    assert [each.time for each in made] == pytest.approx(said.time.tolist())
    sure = [0.5 if not said.held[: k + 1].any() else said.running[k] for k in range(len(made))]
    assert [each.rigid for each in made] == sure
    assert [each.held for each in made] == said.held.tolist()
    forces = [each.force.value if each.force else 0.0 for each in made]
    assert forces == pytest.approx(said.force.tolist(), rel=1e-12)


def test_the_peak_of_a_grasp_still_held_is_the_median_over_trees(arrays, trained):
    model, grasp = trained[0], seen_until(recording(arrays, 11), 640)
    prediction = model.predict(grasp)
    rows = model.windowing.features(model.windowing.samples(grasp)[np.newaxis])[0]
    last = np.flatnonzero(prediction.held)[-1]
    assert prediction.peak_force.value == np.exp(model.force.quantiles(rows)[last, 1])
    means = np.exp(model.force(rows))[prediction.held]
    assert (means != prediction.force[prediction.held]).any()


def test_the_peak_of_a_released_grasp_is_by_its_closing_and_opening(arrays, trained):
    model, off = trained[0], {True: [], False: []}
    for k in range(80, 100):
        for curve in (True, False):
            prediction = (model if curve else replace(model, peak=None)).predict(
                recording(arrays, k)
            )
            true = arrays[0][k, :, 3].max()
            off[curve].append(abs(prediction.peak_force.value / true - 1.0))
    assert np.median(off[True]) < 0.8 * np.median(off[False]) < 0.02


def test_the_peak_does_not_depend_on_how_long_the_hand_stood_still_before(arrays, trained):
    model = trained[0]
    for k in range(80, 100):
        grasp = recording(arrays, k)
        channels = {n: np.concatenate([np.full(300, x[0]), x]) for n, x in grasp.channels.items()}
        channels["time"] = np.arange(grasp.time.size + 300) / 1000.0
        late = model.predict(Recording(channels, grasp.units)).peak_force.value
        assert late == pytest.approx(model.predict(grasp).peak_force.value, rel=0.01)


def test_few_trees_make_a_model_that_can_be_read(data, tmp_path):
    for trees in (1, 2):
        model_file.write(tmp_path / "model.h5", train(data, trees=trees, seed=1, jobs=1)[0])
        assert np.isfinite(model_file.read(tmp_path / "model.h5").force_band.x).all()


def test_a_model_that_would_not_be_read_is_not_written(trained, tmp_path):
    far = replace(trained[0].peak, ends=np.array([0.0, 500.0]))
    with pytest.raises(BadInput, match="logarithm of a peak force"):
        model_file.write(tmp_path / "model.h5", replace(trained[0], peak=far))
    assert not (tmp_path / "model.h5").exists()


def test_a_learning_curve_passes_over_parts_with_too_few_of_a_class(data, monkeypatch):
    monkeypatch.setattr(learning, "FEWEST", 2)  # parts of 1, 5, 20 and all 80 grasps
    counts = [count for count, _ in learning.curve(data, trees=2, jobs=1)]
    assert counts[-2:] == [20, 80] and 1 not in counts


@pytest.mark.parametrize(
    ("option", "said"), [("--seed=-1", "seed = -1"), ("--window=600 ms", "is too long for grasps")]
)
def test_what_cannot_be_learnt_is_one_line(data, tmp_path, capsys, option, said):
    assert main(["train", str(data), "--out", str(tmp_path / "m.h5"), option]) == 2
    prediction = capsys.readouterr().err
    assert said in prediction and prediction.count("\n") == 1


def test_a_damaged_force_is_refused_before_training(data, tmp_path):
    path = tmp_path / "set.h5"
    path.write_bytes(data.read_bytes())
    with h5py.File(path, "r+") as opened:
        table = opened["grasps"][()]
        table["peak_force"][3] = np.inf
        opened["grasps"][...] = table
    with pytest.raises(BadInput, match="a peak force is no number"):
        train(path, trees=2, jobs=1)


def test_stiffness_has_an_interval_by_its_trees(arrays, trained):
    model, grasp = trained[0], recording(arrays, 11)
    prediction = model.predict(grasp)
    rows = model.windowing.features(model.windowing.samples(grasp)[np.newaxis])[0][prediction.held]
    later = model.stiffness.quantiles(rows)[len(rows) // 2 :]
    value, apart = np.exp(np.median(later[:, 1])), np.median(later[:, 2] - later[:, 0])
    assert prediction.stiffness.value == pytest.approx(value)
    assert (prediction.stiffness.low, prediction.stiffness.high) == model.stiffness_band(
        value, apart
    )


def test_one_decision_takes_well_under_a_millisecond(arrays, trained):
    model, _ = trained
    rows = model.windowing.features(arrays[0][:1, :, :3])[0]
    model.windows(rows[:1])
    spent = []
    for row in np.tile(rows, (5, 1)):
        start = time.perf_counter()
        model.windows(row[np.newaxis])
        spent.append(time.perf_counter() - start)
    assert np.median(spent) < 0.5e-3


def test_pipelines_and_grid_search_work(arrays):
    block, rigid, _ = arrays
    pipeline = Pipeline([("features", WindowFeatures()), ("trees", BaggedTrees(5, jobs=1))])
    grid = {"features__window": [0.03, 0.05], "trees__leaf": [5, 20]}
    search = GridSearchCV(pipeline, grid, cv=3).fit(block[..., :3], rigid)
    assert search.best_score_ > 0.9
    recordings = [recording(arrays, k) for k in (0, 79)]
    assert list(search.best_estimator_.predict(recordings)) == [0, 1]
    names = pipeline.named_steps["features"].get_feature_names_out()
    assert list(names) == list(NAMES)


def test_a_grasp_of_the_hand_is_classified(arrays, trained):
    model, prediction = trained
    assert prediction["grasps"] == prediction["unseen_scores"]["grasps"] == 80
    assert prediction["test_scores"]["grasps"] == 20
    assert prediction["test_scores"]["grasps_right"] >= 0.95
    assert prediction["test_scores"]["peak_force_error_percent"] < 15.0
    soft, rigid = model.predict(recording(arrays, 2)), model.predict(recording(arrays, 70))
    assert (soft.decision, rigid.decision) == ("soft", "rigid")
    assert soft.stiffness.value < 3000.0 < rigid.stiffness.value
    assert soft.peak_force.low <= soft.peak_force.value <= soft.peak_force.high
    assert soft.running[soft.held][-1] == soft.probability
    assert soft.force[soft.held][-1] == pytest.approx(soft.peak_force.value, rel=0.05)


def test_a_grasp_still_held_where_its_recording_ends_has_a_force(arrays, trained):
    model, _ = trained
    for k in range(80, 100):
        cut = seen_until(recording(arrays, k), 640)
        prediction = model.predict(cut).peak_force
        assert prediction.value == pytest.approx(cut["force"].max(), rel=0.15)


def test_an_empty_hand_is_no_grasp(trained):
    model, _ = trained
    times = np.arange(500) / 1000.0
    still = {name: np.zeros(500) for name in CHANNELS}
    units = {"time": "s", "current": "A", "position": "rad", "reference": "rad"}
    for sure in (0.5, model.sure, 0.7):  # whatever the probability from which a class is named
        prediction = replace(model, sure=sure).predict(Recording({"time": times, **still}, units))
        assert prediction.decision == "don't know"
        assert prediction.stiffness is None and prediction.peak_force is None


def test_the_same_seed_trains_the_same_bytes(data, trained, tmp_path):
    model, _ = trained
    again, _ = train(data, trees=12, seed=1, jobs=2)
    for name, each in (("a.h5", model), ("b.h5", again)):
        model_file.write(tmp_path / name, each)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()
    back = model_file.read(tmp_path / "a.h5")
    rows = np.random.default_rng(0).standard_normal((50, len(NAMES)))
    assert np.array_equal(back.windows(rows), model.windows(rows))
    whole = np.random.default_rng(0).standard_normal((5, len(hysteresis_features.WHOLE)))
    assert np.array_equal(back.peak(whole), model.peak(whole))


def test_many_windows_are_thinned_and_rounded_with_the_same_bytes(data, tmp_path, monkeypatch):
    """As of a large set: each tree learns from some windows, on features of few levels."""
    monkeypatch.setattr(learning, "FEW", 100)
    monkeypatch.setattr(learning, "MOST_WINDOWS", 400)
    for jobs in (1, 2):
        model, scores = train(data, trees=12, seed=1, jobs=jobs)
        model_file.write(tmp_path / f"{jobs}.h5", model)
        assert scores["test_scores"]["grasps_right"] >= 0.95
    assert (tmp_path / "1.h5").read_bytes() == (tmp_path / "2.h5").read_bytes()
    leaves = np.diff(model.rigid.starts).mean() / 2.0
    assert leaves < 400 / learning.LEAF


def test_a_learning_curve_ends_with_the_model_that_was_trained_on_all(data, trained):
    given, whole = learning.training_set(data, Windowing()), trained[0]
    *_, (count, last) = learning.curve_of(given, trees=2, jobs=1, whole=whole)
    assert count == 80 and last is whole
    part, _ = train(data, trees=2, seed=1, jobs=1, most=40)
    assert part.trained.endswith("40 grasps of it")
    for other in (part, replace(whole, windowing=Windowing(hop=0.02))):
        *_, (count, last) = learning.curve_of(given, trees=2, jobs=1, whole=other)
        assert count == 80 and last is not other
    more = whole.rigid.starts.size
    assert not learning._is_of(whole, given, more) and learning._is_of(whole, given, more - 1)


@pytest.fixture
def file(trained, tmp_path):
    """A model's file."""
    model_file.write(tmp_path / "model.h5", trained[0])
    return tmp_path / "model.h5"


def spoilt(path, place, change):
    """Put another array in place of one of the file's."""
    with h5py.File(path, "r+") as opened:
        values = opened[place][()]
        del opened[place]
        opened[place] = change(values)


def out_of_range(values):
    values = values.copy()
    values[0] = 10_000_000
    return values


def back_to_the_root(values):
    values = values.copy()
    values[values > 0] = 0
    return values


@pytest.mark.parametrize(
    ("place", "change", "why"),
    [
        ("rigid/left", out_of_range, "leads out of its tree"),
        ("rigid/right", back_to_the_root, "leads out of its tree, or back"),
        ("rigid/feature", out_of_range, "asks for a feature"),
        ("rigid/value", lambda v: v + 2.0, "a probability is not between"),
        ("rigid/value", lambda v: v * np.nan, "not finite"),
        ("force/threshold", lambda v: v[:-1], "unequal length"),
        ("force/starts", lambda v: v[::-1].copy(), "starts do not go"),
        ("force/starts", lambda v: v.astype("f8"), "expected an array of int64"),
        ("stiffness/left", lambda v: v[:, np.newaxis], "with 1 axis"),
        ("calibration", lambda v: v[:, ::-1].copy(), "first row must rise"),
        ("force_band", lambda v: v * np.inf, "finite numbers"),
        ("peak/points", lambda v: v[:-1], "expected"),
        ("peak/weight", lambda v: v * np.nan, "not finite"),
        ("peak/scale", lambda v: 0.0 * v, "out of order"),
        ("peak/length", lambda v: -v, "out of order"),
        ("peak/ends", lambda v: v + 200.0, "logarithm of a peak force"),
        ("peak/ends", lambda v: v[::-1].copy(), "out of order"),
    ],
)
def test_a_model_out_of_bounds_is_refused(file, place, change, why):
    spoilt(file, place, change)
    with pytest.raises(BadInput, match=why):
        model_file.read(file)


def test_a_model_that_claims_a_huge_size_is_refused(file):
    with h5py.File(file, "r+") as opened:
        del opened["rigid/left"]
        opened.create_dataset("rigid/left", (10**12,), "<i4", chunks=(1000,))
    with pytest.raises(BadInput, match="claims far more rows"):
        model_file.read(file)


def test_fuzzed_models_are_read_or_refused(file, arrays):
    data, rng = file.read_bytes(), np.random.default_rng(2)
    rows = Windowing().features(arrays[0][:1, :, :3])[0]
    for _ in range(80):
        changed = bytearray(data)
        for place in rng.integers(0, len(data), 6):
            changed[place] = rng.integers(0, 256)
        file.write_bytes(changed)
        try:
            changed_model = model_file.read(file)
            changed_model.windows(rows)
            assert np.isfinite(
                changed_model.peak(np.zeros((1, len(hysteresis_features.WHOLE))))
            ).all()
        except BadInput as error:
            assert "\n" not in str(error)


def test_intervals_of_a_design_without_grasps_to_spare_are_those_of_grasps_not_learnt(tmp_path):
    """Trees grown to a few samples predict their training data as if nothing were uncertain."""
    few, one = tmp_path / "few.h5", tmp_path / "one.h5"
    make(read_spec(TEXT.replace("draws = 20", "draws = 5")), few, workers=1)
    model, _ = train(few, trees=40, jobs=1)
    low, high = model.force_band(50.0, 0.1)
    assert low < 49.0 and high > 51.0
    single = TEXT.replace(', "15 kN/m"', "").replace("draws = 20", "draws = 1")
    make(read_spec(single), one, workers=1)
    with pytest.raises(BadInput, match="two grasps or more of soft and of rigid objects"):
        train(one, trees=2, jobs=1)


def test_the_commands_train_and_evaluate(data, arrays, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["train", str(data), "--out", "model.h5", "--trees", "8", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["unseen_scores"]["grasps"] == 80
    for k in (2, 3, 70, 71):
        recording(arrays, k).write(tmp_path / f"{'soft' if k < 40 else 'hard'}-{k}.h5")
    Path("evaluation.toml").write_text(
        'title = "two"\n[[object]]\nname = "a"\nclass = "soft"\nfile = "soft-*.h5"\n'
        '[[object]]\nname = "b"\nclass = "rigid"\nfile = "hard-*.h5"\nstiffness = "38.3 kN/m"\n'
    )
    more = ["--out", "scores", "--learning-curve", str(data), "--baselines", str(data), "--json"]
    assert main(["evaluate", "model.h5", "evaluation.toml", *more]) == 0
    prediction = json.loads(capsys.readouterr().out)
    assert prediction == json.loads(Path("scores/evaluation.json").read_text())
    assert prediction["f1_grasps"] == 1.0 and prediction["f1_windows"] > 0.9
    assert prediction["from_contact"]["f1_windows"] <= prediction["f1_windows"]
    assert 0.0 <= prediction["stable_after_s"]["soft"] < prediction["stable_after_s"]["rigid"] < 0.2
    counted = {word: sum(prediction["confusion"][word].values()) for word in ("soft", "rigid")}
    assert counted == {row["class"]: row["windows"] for row in prediction["objects"]} and sum(
        row["windows"] for row in prediction["reliability"]["rows"]
    ) == sum(counted.values())
    assert 0.0 <= prediction["reliability"]["calibration_error"] < 0.2
    assert prediction["force"]["grasps"] == prediction["force"]["answered"] == 4
    assert prediction["stiffness"]["grasps"] == 2  # only one object's is known
    assert [row["grasps"] for row in prediction["learning_curve"]] == [80]
    assert prediction["learning_curve"][0]["f1_grasps"] == 1.0
    for each in prediction["baselines"].values():
        assert [row["name"] for row in each["objects"]] == ["a", "b"]
        assert 0.0 <= each["f1_windows"] <= 1.0
    page = Path("scores/report.html").read_text()
    for said in ("over 2 objects", "Look-up of current", "Learning curve", "Least well recognised"):
        assert said in page
    assert main(["evaluate", "model.h5", "soft-2.h5"]) == 0
    assert re.match(r"soft .*\n  stiffness .* N/m .*\n  peak grip", capsys.readouterr().out)
    assert main(["evaluate", "model.h5", "evaluation.toml"]) == 0
    said = capsys.readouterr().out
    assert "estimated for 4 of 4 grasps" in said and "stiffness: off" in said
    recording(arrays, 2, current=np.zeros(arrays[2].size)).write(tmp_path / "still.h5")
    assert main(["evaluate", "model.h5", "still.h5", "--out", "x"]) == 2
    assert "are for an evaluation.toml" in capsys.readouterr().err
    assert main(["evaluate", "model.h5", "still.h5"]) == 0
    assert re.match(r"don't know .*\n.*no contact in the current", capsys.readouterr().out)


def test_bad_recordings_are_reported_in_one_line(file, arrays, tmp_path, capsys):
    whole = recording(arrays, 2)
    parts = {n: x for n, x in whole.channels.items() if n != "position"}
    units = {n: whole.units[n] for n in parts}
    Recording(parts, units).write(tmp_path / "part.h5")
    assert main(["evaluate", str(file), str(tmp_path / "part.h5")]) == 2
    assert 'no channel "position"' in capsys.readouterr().err
    (tmp_path / "nan.csv").write_text("time_s,current_A\n0,1\n0.1,nan\n")
    assert main(["evaluate", str(file), str(tmp_path / "nan.csv")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert main(["evaluate", str(tmp_path / "part.h5"), str(tmp_path / "part.h5")]) == 2
    assert "schema" in capsys.readouterr().err
    assert main(["train", str(tmp_path / "part.h5")]) == 2
    assert "schema" in capsys.readouterr().err
    milli = whole.with_channels({"force": 1e3 * whole.time}, {"force": "mN"})
    milli.write(tmp_path / "milli.h5")
    (tmp_path / "e.toml").write_text('[[object]]\nclass = "soft"\nfile = "milli.h5"\n')
    assert main(["evaluate", str(file), str(tmp_path / "e.toml")]) == 2
    assert 'channel "force" comes in mN, expected N' in capsys.readouterr().err
    with pytest.raises(BadInput, match="no numbers"):
        Windowing().features(np.full((1, 300, 3), np.nan))
    with pytest.raises(BadInput, match="at least 4 samples"):
        replace(Windowing(), window=1e-3)


def test_training_never_reads_the_ten_objects():
    package = Path(__file__).parents[2] / "hannes"
    texts = [each.read_text(encoding="utf-8") for each in package.rglob("*.py")]
    assert not any("ten_objects" in text or "benchmarks import" in text for text in texts)
