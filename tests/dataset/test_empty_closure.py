"""Hands that close on nothing: means of current and lag, in the table of a data set."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from hannes import load_experiment, simulate_many
from hannes.core.errors import BadInput
from hannes.dataset.empty_closure import empty_means, mean_size, numbers_of
from hannes.dataset.make import make
from hannes.dataset.read import _numbers, read
from hannes.dataset.sampling import emptied, sample_grasp
from hannes.dataset.shard import recorded
from hannes.dataset.spec import load_spec, read_spec

TEXT = """
title = "hands"
seed = 5
duration = "0.2 s"
controller = "sampled"
channels = ["current", "position", "reference", "force"]
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.2 s", "3 rad"]]
[empty]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.2 s", "3 rad"], ["0.24 s", "3 rad"]]
[values]
"motor.dry_friction" = { spread = "0.3" }
"noise.current" = "10 mA"
"object.stiffness" = { log_uniform = ["300 N/m", "60 kN/m"] }
[[grasps]]
name = "closed"
shape = "cylinder"
draws = 2
[[grasps]]
name = "tested"
role = "test"
shape = "cylinder"
[[grasps]]
name = "pressed"
role = "pressed"
shape = "cylinder"
draws = 3
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A data set of six grasps, three of them of hands that closed on nothing."""
    path = tmp_path_factory.mktemp("hands") / "set.h5"
    make(read_spec(TEXT), path, workers=1, progress=False)
    return path


def test_means_of_straight_lines():
    time = np.arange(205) / 1e3
    found = empty_means(0.2 + time, 3.0 * time, 4.0 * time, 20, 20)
    middle = 0.02 * (np.arange(10) + 0.5) - 0.5e-3
    assert found == pytest.approx(np.concatenate([0.2 + middle, middle]))
    assert mean_size(1000.0) == 20 and mean_size(33.0) == 0


def test_the_hands_of_pressed_grasps_close_on_nothing(whole):
    spec, data = read_spec(TEXT), read(whole)
    shown = data.empty(np.arange(6))
    assert shown.shape == (6, numbers_of(spec.empty)) == (6, 24)
    assert np.isnan(shown[:3]).all()
    for k in (3, 4, 5):
        alone = emptied(spec, sample_grasp(spec, k))
        assert alone.experiment.object is None
        pair = (alone.hand, replace(alone.experiment, noise={}))
        names = ("current", "position", "reference")
        (ran,) = simulate_many([pair], channels=names, rtol=1e-3, workers=1, progress=False)
        wanted = empty_means(*(ran[name] for name in names), 20, 24)
        assert shown[k, :12] == pytest.approx(wanted[:12], abs=5 * 0.01 / np.sqrt(20.0))
        assert shown[k, 12:] == pytest.approx(wanted[12:], abs=1e-6)
    assert np.ptp(shown[3:, 5]) > 0.01  # the hands differ


def test_its_noise_is_not_that_of_the_grasp(whole):
    spec = read_spec(TEXT)
    grasp = sample_grasp(spec, 3)
    assert emptied(spec, grasp).seed != grasp.seed
    assert recorded(spec, 3)["current"].size == 201


def test_a_data_set_without_such_hands_has_no_numbers(tmp_path):
    without = TEXT[: TEXT.index("[empty]")] + TEXT[TEXT.index("[values]") :]
    make(read_spec(without), tmp_path / "set.h5", workers=1, progress=False)
    data = read(tmp_path / "set.h5")
    assert data.empty(np.arange(6)).shape == (6, 0)
    assert "empty" not in data.table.dtype.names


@pytest.mark.parametrize(
    "old, new, why",
    [
        ('["0.24 s", "3 rad"]', '["24 s", "3 rad"]', "empty"),
        ('["0.24 s", "3 rad"]', '["0.01 s", "3 rad"]', "empty"),
        ('[empty]\nkind = "ramp"', '[empty]\nkind = "file"', "empty"),
        ('duration = "0.2 s"', 'duration = "0.2 s"\nsampling = "990 Hz"', "empty"),
    ],
)
def test_a_closure_that_cannot_be_is_refused(old, new, why):
    text = TEXT.replace(old, new, 1)
    text = text.replace('["0.2 s", "3 rad"], ["0.01 s"', '["0.005 s", "3 rad"], ["0.01 s"')
    with pytest.raises(BadInput, match=why):
        read_spec(text)


@pytest.mark.parametrize("shape, kind", [((2000,), "<f4"), ((4, 4), "<f4"), ((24,), "<f8")])
def test_a_field_that_is_no_such_thing_is_refused(shape, kind, whole, tmp_path):
    with h5py.File(whole, "r") as given, h5py.File(tmp_path / "x.h5", "w") as file:
        for name, value in given.attrs.items():
            file.attrs[name] = value
        given.copy("channels", file)
        rows = given["grasps"][()]
        fields = [(name, rows.dtype[name]) for name in rows.dtype.names if name != "empty"]
        other = np.zeros(rows.size, [*fields, ("empty", kind, shape)])
        for name, _ in fields:
            other[name] = rows[name]
        file["grasps"] = other
    with pytest.raises(BadInput, match="plain numbers"):
        read(tmp_path / "x.h5")


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e30])
def test_a_closure_with_a_gap_in_its_numbers_is_refused(value, whole, tmp_path):
    path = tmp_path / "x.h5"
    path.write_bytes(whole.read_bytes())
    with h5py.File(path, "r+") as file:
        rows = file["grasps"][()]
        rows["empty"][4, 7] = value
        file["grasps"][...] = rows
    with pytest.raises(BadInput, match="grasp 4 has an empty closure with gaps"):
        read(path)


def test_the_shipped_set_has_the_command_that_ships():
    (variant,) = load_experiment("empty-closure")
    assert np.array_equal(load_spec("held").empty.knots, variant.experiment.reference.knots)
    assert variant.experiment.duration == variant.experiment.reference.knots[0, -1]
    assert variant.experiment.controller == "sampled"


def test_a_row_counts_every_number_of_an_empty_closure():
    row = np.dtype([("stiffness", "<f8"), ("empty", "<f4", (160,))])
    assert _numbers(row) == 161
