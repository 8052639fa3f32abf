"""Recordings in other programs' formats: read back by those programs' own libraries."""

import io

import numpy as np
import pytest

from hannes import Recording
from hannes.commands.cli import main
from hannes.core.errors import BadInput


@pytest.fixture
def recording():
    rng, time = np.random.default_rng(3), np.linspace(0.0, 0.2, 21)
    channels = {"time": time, "current": rng.normal(size=21), "arm.angle": rng.normal(size=21)}
    units = {"time": "s", "current": "A", "arm.angle": "rad"}
    return Recording(channels, units, plant="hand", seed=4, source="simulated")


def test_pandas_has_unit_in_every_column(recording):
    pytest.importorskip("pandas")
    frame = recording.to_pandas()
    assert list(frame.columns) == ["current_A", "arm.angle_rad"] and frame.index.name == "time_s"
    assert np.array_equal(frame["current_A"], recording["current"])
    assert np.array_equal(frame.index, recording.time)
    assert frame.attrs["plant"] == "hand" and frame.attrs["seed"] == 4


def test_xarray_has_units_as_attributes(recording):
    pytest.importorskip("xarray")
    made = recording.to_xarray()
    assert made["current"].attrs["units"] == "A" and made["time"].attrs["units"] == "s"
    assert np.array_equal(made["arm.angle"], recording["arm.angle"])
    assert made.sel(time=0.1, method="nearest")["current"] == recording["current"][10]


def test_matlab_file_has_columns_units_and_the_same_bytes_again(recording, tmp_path):
    from scipy.io import loadmat

    recording.to_mat(tmp_path / "a.mat")
    recording.to_mat(tmp_path / "b.mat")
    assert (tmp_path / "a.mat").read_bytes() == (tmp_path / "b.mat").read_bytes()
    found = loadmat(tmp_path / "a.mat", simplify_cells=True)
    assert np.array_equal(found["current"], recording["current"])
    assert np.array_equal(found["arm_angle"], recording["arm.angle"])
    assert found["units"]["arm_angle"] == "rad" and found["metadata"]["seed"] == 4
    assert loadmat(tmp_path / "a.mat")["time"].shape == (21, 1)


def test_matlab_names_that_would_clash_are_refused(tmp_path):
    channels = {"time": [0, 1], "a.b": [0, 1], "a-b": [0, 1]}
    clash = Recording(channels, {"time": "s", "a.b": "1", "a-b": "1"})
    with pytest.raises(BadInput, match=r"a\.b, a-b"):
        clash.to_mat(tmp_path / "clash.mat")


def test_mcap_log_holds_every_sample_to_the_bit(recording, tmp_path):
    import json

    reader = pytest.importorskip("mcap.reader")
    recording.to_mcap(tmp_path / "a.mcap")
    content = io.BytesIO((tmp_path / "a.mcap").read_bytes())
    found = list(reader.make_reader(content).iter_messages())
    assert [each[2].log_time for each in found] == [round(1e9 * t) for t in recording.time]
    rows = [json.loads(each[2].data) for each in found]
    for name in recording.names:
        column = [row[f"{name}_{recording.units[name]}"] for row in rows]
        assert np.array_equal(column, recording[name])


@pytest.mark.parametrize("suffix", ["mat", "mcap", "csv", "h5"])
def test_command_writes_by_the_name(recording, tmp_path, suffix, capsys):
    recording.to_hdf5(tmp_path / "from.h5")
    target = tmp_path / f"to.{suffix}"
    assert main(["export", str(tmp_path / "from.h5"), "--out", str(target)]) == 0
    assert target.stat().st_size > 0 and str(target) in capsys.readouterr().out


def test_command_refuses_other_names(recording, tmp_path, capsys):
    recording.to_hdf5(tmp_path / "from.h5")
    assert main(["export", str(tmp_path / "from.h5"), "--out", str(tmp_path / "to.xls")]) == 2
    assert "expected a recording named" in capsys.readouterr().err


def test_a_missing_library_is_named_with_what_to_type():
    from hannes.core.io.optional import library

    with pytest.raises(BadInput, match=r'pip install "hannes\[export\]"'):
        library("no_such_library_here", "export")
