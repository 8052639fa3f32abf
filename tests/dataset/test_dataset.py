"""Data sets: each grasp depends on its seed alone, nothing is lost, bytes are always the same."""

import json
import re
import resource
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.dataset.hdf5_file import fingerprint, write
from hannes.dataset.make import Shards, make, numbered
from hannes.dataset.read import read
from hannes.dataset.sampling import sample_grasp
from hannes.dataset.shard import Shard, count, made, recorded
from hannes.dataset.spec import load_spec, read_spec

REFERENCE = """
duration = "0.15 s"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.1 s", "3 rad"]]
"""
TEXT = (
    """
title = "small"
seed = 3
channels = ["position", "current", "reference"]
"""
    + REFERENCE
    + """
[values]
"motor.dry_friction" = { spread = "0.05" }
"mcp.spring_*" = { spread = "0.02" }
"noise.current" = "10 mA"
"resolution.position" = "1.5 mrad"
[[grasps]]
name = "empty hand"
shape = "none"
draws = 30
[grasps.values]
"command.speed" = ["0.9", "1.1"]
[[grasps]]
name = "cylinders"
shape = "cylinder"
role = "test"
draws = 250
[grasps.values]
"object.radius" = { uniform = ["15 mm", "40 mm"] }
"object.stiffness" = { log_uniform = ["300 N/m", "60 kN/m"] }
"object.y" = { uniform = ["-60 mm", "-35 mm"] }
"""
)


@pytest.fixture(scope="module")
def spec():
    """Three hundred and ten grasps in four parts."""
    return read_spec(TEXT)


@pytest.fixture(scope="module")
def whole(spec, tmp_path_factory):
    """The data set of an uninterrupted run by one process."""
    path = tmp_path_factory.mktemp("whole") / "set.h5"
    result = make(spec, path, workers=1, progress=False)
    assert result == {
        "out": str(path), "grasps": 310, "shards": 4, "shards_simulated": 4, "failed": 0
    }  # fmt: skip
    assert [each.name for each in path.parent.iterdir()] == ["set.h5"]
    return path


def test_the_bytes_are_the_same_for_any_number_of_workers(spec, whole, tmp_path):
    make(spec, tmp_path / "again.h5", workers=2, progress=False)
    assert (tmp_path / "again.h5").read_bytes() == whole.read_bytes()


@pytest.mark.parametrize("number", [0, 31, 309])
def test_each_grasp_is_reproducible_alone(spec, whole, number):
    alone = recorded(read_spec(spec.text), number)
    with h5py.File(whole) as file:
        for name in spec.channels:
            assert np.array_equal(file["channels"][name][number], alone[name].astype("f4"))


def test_it_reads_with_h5py_alone_and_says_what_is_what(whole):
    with h5py.File(whole) as file:
        current, table = file["channels/current"], file["grasps"]
        units = dict(zip(table.dtype.names, table.attrs["units"].astype(str), strict=True))
        assert current.shape == (310, 151) and current.attrs["unit"] == b"A"
        assert current.chunks == (100, 151) and current.compression == "gzip"
        assert current.dims[1][0][-1] == 0.15
        assert units["object.stiffness"] == "N/m" and units["contact"] == "s"
        assert read_spec(file.attrs["specification"].decode()).count == 310
        assert file.attrs["seed"] == 3
        result = json.loads(file.attrs["meanings"])
        assert set(result) <= {*file.attrs, *file} and result["border"].startswith("N/m")
        own = set(table.dtype.names) - set(json.loads(table.attrs["meanings"]))
        assert all("." in name for name in own)  # the others are parameters by full name


def test_the_five_lines_of_the_tutorial_read_it(whole, capsys):
    page = Path(__file__).parents[2] / "docs" / "tutorials" / "classifier.md"
    (block,) = re.findall(
        r"```python\n(import h5py.*?)```", page.read_text(encoding="utf-8"), re.DOTALL
    )
    assert len(block.split("\n\n")) == 2 and len(block.replace("\n\n", "\n").splitlines()) == 5
    exec(compile(block.replace("balls.h5", str(whole)), page.name, "exec"), {})
    assert "'object.stiffness': b'N/m', " in capsys.readouterr().out


def test_levels_are_crossed_and_draws_stand_clear_of_the_hand(spec, whole):
    found = read(whole)
    assert np.array_equal(np.unique(found.table["command.speed"][:60]), [0.9, 1.1])
    assert found.role("test").sum() == 250 and not found.role("test")[:60].any()
    wide = found.table["object.radius"][60:]
    assert wide.min() < 0.018 and 0.03 < wide.max() < 0.04
    assert np.ptp(found.table["motor.dry_friction"]) > 0.0
    assert sample_grasp(spec, 200).values["object.radius"] == found.table["object.radius"][200]


def test_damaged_parts_are_found_and_redone(spec, whole, tmp_path):
    path = tmp_path / "set.h5"
    data = bytearray(whole.read_bytes())
    with h5py.File(whole) as file:
        chunk = file["channels/current"].id.get_chunk_info(1)
    data[chunk.byte_offset + chunk.size // 2] ^= 1
    path.write_bytes(data)
    assert make(spec, path, workers=1, progress=False)["shards_simulated"] == 1
    assert path.read_bytes() == whole.read_bytes()
    path.write_bytes(whole.read_bytes()[: chunk.byte_offset])  # beyond repair
    assert make(spec, path, workers=1, progress=False)["shards_simulated"] == 4
    assert path.read_bytes() == whole.read_bytes()
    assert make(spec, path, workers=1, progress=False)["shards_simulated"] == 0


@pytest.mark.parametrize(
    "place", ["channels/time", "title", "channels/current.unit", "grasps.units"]
)
def test_damage_beside_the_parts_is_mended(spec, whole, tmp_path, place):
    path = tmp_path / "set.h5"
    data = bytearray(whole.read_bytes())
    path.write_bytes(data)
    with h5py.File(path, "r+") as file:
        if place == "channels/time":
            file[place][7] += 1e-3
        else:
            item, _, name = place.rpartition(".")
            owner = file[item] if item else file
            owner.attrs[name] = b"?"
    assert path.read_bytes() != whole.read_bytes()
    assert make(spec, path, workers=1, progress=False)["shards_simulated"] == 0
    assert path.read_bytes() == whole.read_bytes()


def test_a_worker_of_another_version_is_refused(spec):
    with pytest.raises(BadInput, match="another version"):
        numbered(spec.text, 0, "the mark of another model")


def test_a_damaged_part_of_an_unfinished_run_is_redone(spec, whole, tmp_path):
    shards = Shards(tmp_path / "set.h5", spec)
    for k in range(3):
        shards.write(k, made(spec, k).packed())
    data = bytearray(shards.path(1).read_bytes())
    data[len(data) // 2] ^= 16
    shards.path(1).write_bytes(data)
    shards.path(2).write_bytes(b"")
    assert make(spec, tmp_path / "set.h5", workers=1, progress=False)["shards_simulated"] == 3
    assert (tmp_path / "set.h5").read_bytes() == whole.read_bytes()


@pytest.mark.parametrize("place", range(0, 100, 9))
def test_no_damage_of_a_part_goes_unseen(spec, place):
    data = bytearray(_SHARD.setdefault(0, made(spec, 0).packed()))
    data[len(data) * place // 100] ^= 4
    shard = Shard.unpacked(bytes(data))
    assert (
        shard is None or shard.digest == Shard.unpacked(_SHARD[0]).digest
    )  # a name's or a date's bit


_SHARD: dict[int, bytes] = {}


def test_a_killed_run_goes_on_where_it_was(spec, whole, tmp_path):
    (tmp_path / "set.toml").write_text(TEXT)
    command = [sys.executable, "-m", "hannes", "dataset", "set.toml", "--out", "set.h5"]
    command += ["--workers", "1"]
    rng = np.random.default_rng(5)
    for _ in range(3):
        run = subprocess.Popen(command, cwd=tmp_path)
        time.sleep(rng.uniform(0.5, 2.0))
        run.send_signal(signal.SIGKILL)
        run.wait()
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "set.h5").read_bytes() == whole.read_bytes()
    assert not list(tmp_path.glob(".parts*"))


def test_an_interrupted_run_says_so_and_leaves_nobody_at_work(whole, tmp_path):
    (tmp_path / "set.toml").write_text(TEXT.replace("draws = 250", "draws = 2500"))
    command = [sys.executable, "-m", "hannes", "dataset", "set.toml", "--out", "set.h5"]
    run = subprocess.Popen(
        command, cwd=tmp_path, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    while not list(tmp_path.glob(".shards*/*.shard")) and run.poll() is None:
        time.sleep(0.02)
    run.send_signal(signal.SIGINT)
    _, result = run.communicate(timeout=60)
    assert run.returncode == 130 and "goes on where it was" in result
    assert "Traceback" not in result


def test_a_full_disk_is_reported_and_the_run_resumes_after(whole, tmp_path):
    (tmp_path / "set.toml").write_text(TEXT)
    command = [sys.executable, "-m", "hannes", "dataset", "set.toml", "--out", "set.h5"]
    command += ["--workers", "1"]

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, 150_000))  # bytes of a file: a part's

    ended = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, preexec_fn=limited
    )
    assert ended.returncode == 2 and ended.stderr.count("\n") == 1
    assert "run the same again" in ended.stderr and "Traceback" not in ended.stderr
    assert not (tmp_path / "set.h5").exists() and list(tmp_path.glob(".shards*/*.shard"))
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "set.h5").read_bytes() == whole.read_bytes()


@pytest.mark.parametrize("error", [
    OSError(28, "No space left on device"),
    OSError("Can't write data (file write failed: errno = 28, error message = 'No space')"),
    RuntimeError("Unspecified error (errno = 122, error message = 'Disk quota exceeded')"),
])  # fmt: skip
def test_a_full_disk_is_reported_however_hdf5_words_it(spec, tmp_path, error):
    def shards():
        raise error
        yield

    with pytest.raises(BadInput, match="no space left on the disk"):
        write(tmp_path / "set.h5", spec, shards())


@pytest.fixture
def cluster():
    """A Dask scheduler and two workers, processes of their own over TCP."""
    start = [sys.executable, "-m", "dask", "scheduler"]
    common = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--dashboard-address", ":0"]
    scheduler = subprocess.Popen([*start, *common], stderr=subprocess.PIPE, text=True)
    address = next(x.split()[-1] for x in scheduler.stderr if "Scheduler at:" in x)
    start = [sys.executable, "-m", "dask", "worker"]
    how = ["--nworkers", "1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    workers = [
        subprocess.Popen([*start, address, *how], stderr=subprocess.DEVNULL) for _ in range(2)
    ]
    yield address, workers
    for each in (*workers, scheduler):
        each.kill()
        each.wait()
    scheduler.stderr.close()


@pytest.mark.slow
def test_a_cluster_gives_the_same_bytes_and_survives_a_killed_worker(cluster, whole, tmp_path):
    address, workers = cluster
    (tmp_path / "set.toml").write_text(TEXT)
    command = [sys.executable, "-m", "hannes", "dataset", "set.toml", "--out", "set.h5"]
    run = subprocess.Popen([*command, "--backend", "dask", "--scheduler", address], cwd=tmp_path)
    while not list(tmp_path.glob(".shards*/*.shard")) and run.poll() is None:
        time.sleep(0.02)
    workers[0].kill()
    assert run.poll() is None and 0 < len(list(tmp_path.glob(".shards*/*.shard"))) < 4
    assert run.wait(timeout=120) == 0
    assert (tmp_path / "set.h5").read_bytes() == whole.read_bytes()


def test_the_docs_have_the_commands_of_a_cluster():
    page = Path(__file__).parents[2] / "docs" / "how-to" / "make-a-data-set.md"
    text = page.read_text(encoding="utf-8")
    for words in ("`dask scheduler`", "`dask worker tcp://HOST:8786`", "pip install '.[cluster]'"):
        assert words in text
    assert "--backend dask --scheduler tcp://HOST:8786" in text


def test_a_missing_scheduler_is_reported(spec, tmp_path):
    with pytest.raises(BadInput, match="no Dask scheduler answers"):
        make(spec, tmp_path / "set.h5", backend="dask", scheduler="tcp://127.0.0.1:1")


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('"command.speed"', '"command.sped"', 'command.sped.*did you mean "command.speed"'),
        ("draws = 250", "draws = 0", "draws must be a whole number from 1"),
        ('["300 N/m", "60 kN/m"]', '["60 kN/m", "300 N/m"]', "a lower, then a higher value"),
        ('"60 kN/m"', '"60 kN"', "expected a value in N/m"),
        ('"40 mm"', '"400 mm"', "above its upper bound"),
        ('["-60 mm", "-35 mm"]', '["-12 mm", "-10 mm"]', "grasp 60 .*intersects the open hand"),
        ("log_uniform", "gaussian", 'unknown key "grasps.1..values.object.stiffness.gaussian"'),
        ('"mcp.spring_*"', '"mcp.sprung_*"', "stands for no parameter"),
        ('name = "cylinders"', 'name = "empty hand"', "two groups of one name"),
        ('"current", ', '"amps", ', 'has "amps"'),
        ("spread = ", "spraed = ", "did you mean"),
        ('shape = "cylinder"', 'shape = "cube"', "expected one of"),
    ],
)
def test_a_bad_specification_is_reported_in_one_line(tmp_path, capsys, old, new, why):
    (tmp_path / "bad.toml").write_text(TEXT.replace(old, new, 1))
    assert old in TEXT
    arguments = ["dataset", str(tmp_path / "bad.toml"), "--out", str(tmp_path / "bad.h5")]
    assert main([*arguments, "--workers", "1"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(why, line), line


def test_what_is_no_data_set_is_not_overwritten(spec, tmp_path):
    (tmp_path / "notes.h5").write_text("my notes")
    with pytest.raises(BadInput, match="holds something else"):
        make(spec, tmp_path / "notes.h5")
    Recording({"time": [0.0, 1.0], "current": [0.0, 1.0]}, {"time": "s", "current": "A"}).write(
        tmp_path / "measured.h5"
    )
    with pytest.raises(BadInput, match="holds something else"):
        make(spec, tmp_path / "measured.h5")
    with pytest.raises(BadInput, match=r"named \.h5"):
        make(spec, tmp_path / "set.csv")


def test_another_anatomy_is_another_data_set(spec):
    longer = replace(spec, hand=spec.hand.with_values({"index.second_length": 50e-3}))
    assert fingerprint(longer) != fingerprint(spec) == fingerprint(replace(spec))


def test_the_shipped_ones_are_whole():
    design, large = load_spec("eighteen"), load_spec("large")
    roles = [group.role for group in design.groups]
    assert design.count == 18 and roles.count("train") == 16 and roles.count("test") == 2
    assert {sample_grasp(design, k).group.shape for k in range(18)} == {
        "cylinder",
        "prism",
        "sphere",
    }
    assert large.count == 10_000 and count(large) == 100
    seated = load_spec("seated")
    for number in range(0, seated.count, 99):
        sampled, shape = (
            sample_grasp(seated, number).values,
            sample_grasp(seated, number).group.shape,
        )
        assert abs(sampled["object.x"] - (4e-3 if shape == "sphere" else 14e-3)) <= 4e-3
    with pytest.raises(BadInput, match='did you mean "large"'):
        load_spec("larger")


def test_one_that_ships_draws_poses_of_fixed_and_floating_objects():
    poses = load_spec("poses")
    sampled = [sample_grasp(poses, number).values for number in range(poses.count)]
    assert {each["floating_object.free"] for each in sampled} == {0.0, 1.0}
    for name, most in (("tilt_x", 15.0), ("tilt_y", 10.0), ("turn", 20.0)):
        angles = np.degrees([each.get(f"object.{name}", 0.0) for each in sampled])
        assert 0.9 * most < np.abs(angles).max() <= most


def test_a_damaged_or_foreign_file_is_refused(whole, tmp_path):
    path = tmp_path / "bad.h5"
    data = whole.read_bytes()
    path.write_bytes(data[: len(data) // 3])
    with pytest.raises(BadInput, match="it is cut off: copy it again, or make it anew"):
        read(path)
    path.write_bytes(data)
    with h5py.File(path, "r+") as file:
        file["channels/current"][7, 3] = np.nan
    found = read(path)
    with pytest.raises(BadInput, match="no number"):
        list(found.blocks(np.arange(20), ("current",)))
    with pytest.raises(BadInput, match='channel "force" is missing'):
        list(found.blocks(np.arange(20), ("force",)))
    with h5py.File(path, "r+") as file:
        file.attrs["schema"] = np.bytes_(b"other-1")
    with pytest.raises(BadInput, match="schema is 'other-1'"):
        read(path)


def test_fuzzed_files_are_read_or_refused(whole, tmp_path):
    data, rng = whole.read_bytes(), np.random.default_rng(1)
    path = tmp_path / "fuzzed.h5"
    for _ in range(60):
        changed = bytearray(data)
        for place in rng.integers(0, 6000, 8):
            changed[place] = rng.integers(0, 256)
        path.write_bytes(changed)
        try:
            found = read(path)
            list(found.blocks(np.arange(min(50, found.table.size)), ("current",)))
        except BadInput:
            pass


def test_a_table_that_claims_a_huge_size_is_refused(whole, tmp_path):
    path = tmp_path / "huge.h5"
    path.write_bytes(whole.read_bytes())
    with h5py.File(path, "r+") as file:
        kind = file["grasps"].dtype
        del file["grasps"]
        file.create_dataset("grasps", (10**11,), kind, chunks=(100,))
    with pytest.raises(BadInput, match="claims far more rows"):
        read(path)
