"""Recordings on disk: exact round trips, equal bytes, and one clear line for any bad file."""

import gzip
import io
import os
import subprocess
import sys
import time as clock
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from hannes.core.errors import BadInput
from hannes.core.io import bounded
from hannes.core.io.limits import MAGNITUDE
from hannes.core.recording import hdf5
from hannes.core.recording.recording import Recording

FINITE = st.floats(-MAGNITUDE, MAGNITUDE)
TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=20)
SUFFIXES = ["csv", "csv.gz", "h5", "hdf5"]
same_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    instants = sorted(draw(st.sets(FINITE, min_size=2, max_size=8)))
    names = draw(st.lists(st.sampled_from(["zeta", "a_b", "f.x", "duty"]), min_size=1, unique=True))
    rows = hnp.arrays(np.float64, len(instants), elements=FINITE)
    units = draw(st.lists(st.sampled_from(["1", "N m/rad", "µm", "m/s^2"]), min_size=4, max_size=4))
    return Recording(
        {"time": instants} | {name: draw(rows) for name in names},
        {"time": "s"} | dict(zip(names, units, strict=False)),
        plant=draw(TEXT),
        experiment=draw(TEXT),
        hand=draw(TEXT),
        seed=draw(st.none() | st.integers(0, 2**63 - 1)),
        source=draw(st.sampled_from(["simulated", "measured"])),
    )


def example() -> Recording:
    time = np.arange(50) * 1e-3
    channels = {"time": time, "reference": np.sin(time), "current": time, "duty": -time}
    units = {"time": "s", "reference": "rad", "current": "A", "duty": "1"}
    toml = "title = 'µ'\n" * 9000
    return Recording(channels, units, "hand", toml, "base = 'hannes'", 7, "simulated")


@same_folder
@given(one=recordings())
def test_hdf5_carries_everything(one: Recording, tmp_path: Path) -> None:
    one.write(tmp_path / "r.h5")
    back = Recording.read(tmp_path / "r.h5")
    assert back == one and back.names == one.names


@same_folder
@given(one=recordings(), suffix=st.sampled_from(["csv", "csv.gz"]))
def test_csv_carries_channels_exactly(one: Recording, suffix: str, tmp_path: Path) -> None:
    one.write(tmp_path / f"r.{suffix}")
    back = Recording.from_csv(tmp_path / f"r.{suffix}", **{k: getattr(one, k) for k in hdf5._TEXTS})
    assert back == Recording(**(vars(one) | {"seed": None}))
    for name, values in one.channels.items():
        assert np.array_equal(np.signbit(values), np.signbit(back[name]))


@pytest.mark.parametrize("size", [0, 1, 60_000, 60_001, 1_000_000])
def test_hdf5_carries_texts_of_any_length(tmp_path: Path, size: int) -> None:
    one = replace(example(), experiment="e" * size, hand="h" * size)
    one.write(tmp_path / "r.h5")
    assert Recording.read(tmp_path / "r.h5") == one


BYTES = """
import sys, tests.core.test_recording_files as t
for path in sys.argv[1:]: t.example().write(path)
"""


def test_same_content_same_bytes(tmp_path: Path) -> None:
    ones = [tmp_path / f"one.{suffix}" for suffix in SUFFIXES]
    root = Path(__file__).parents[2]
    subprocess.run([sys.executable, "-c", BYTES, *map(str, ones)], check=True, cwd=root)
    clock.sleep(1.1)  # a time stamp would have moved on
    for one in ones:
        two = one.with_name(one.name.replace("one", "two"))
        example().write(two)
        assert one.read_bytes() == two.read_bytes()


def test_reads_a_large_csv_fast(tmp_path: Path) -> None:
    rows = np.random.default_rng(1).normal(size=(8, 25_000))
    names = [f"c{i}" for i in range(8)]
    units = dict.fromkeys(names, "1") | {"time": "s"}
    one = Recording({"time": np.arange(25_000.0), **dict(zip(names, rows, strict=True))}, units)
    one.to_csv(tmp_path / "r.csv")
    start = clock.perf_counter()
    back = Recording.read(tmp_path / "r.csv")
    assert clock.perf_counter() - start < 2  # some 0.1 s on an idle machine
    assert back == one


def test_reads_what_spreadsheets_and_people_write(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_bytes('\ufeff"time_s", speed_rad/s,a_1\r\n0,+1, 2.\r\n.5,1e3,-0\r\n\r\n'.encode())
    one = Recording.read(path)
    assert one.units == {"time": "s", "speed": "rad/s", "a": "1"}
    assert one["speed"].tolist() == [1, 1000] and one.time.tolist() == [0, 0.5]
    path.write_text("a_1,time_s\n5,0\n6,1\n")
    assert Recording.read(path).time.tolist() == [0, 1]


HEAD = "time_s,current_A\n"


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", 1, "empty"),
        ("\n\n", 1, "empty"),
        (HEAD, 1, "ends here"),
        (HEAD + "0,1\n", 2, "ends here"),
        ("0,1\n1,2\n", 1, "expected a header"),
        ("time_s,current\n0,1\n1,2\n", 1, "'current' is not of the form name_unit"),
        ("time_s,current_\n0,1\n1,2\n", 1, "not of the form name_unit"),
        ("time_s,_A\n0,1\n1,2\n", 1, "not of the form name_unit"),
        ("time_s,\n0,1\n1,2\n", 1, "not of the form name_unit"),
        ("time_s;current_A\n0;1\n1;2\n", 1, "separate columns by commas"),
        ("time;current\n0;1\n1;2\n", 1, "separate columns by commas"),
        ("time_ms,current_A\n0,1\n1,2\n", 1, "time_s"),
        ("t_s,current_A\n0,1\n1,2\n", 1, "expected a column time_s, got t, current"),
        ("time_s,a_A,a_mA\n0,1,2\n1,2,3\n", 1, '"a" has more than one column'),
        ("time_s,a!_A\n0,1\n1,2\n", 1, "no channel name"),
        ("time_s,a_A$\n0,1\n1,2\n", 1, "needs a unit"),
        ("time_s\n0\n1\n", 1, "at least one channel besides time"),
        ('time_s,"a_A\n0,1\n1,2\n', 1, "unreadable header"),
        (HEAD + "0,1\n1,abc\n", 3, "current = 'abc' is not a number"),
        (HEAD + "0,1\n1,\n", 3, "current = '' is not a number"),
        (HEAD + "0,1\n1,nan\n2,3\n", 3, "current is not finite"),
        (HEAD + "0,1\n1,-Inf\n2,3\n", 3, "current is not finite"),
        (HEAD + "0,1\n1,1e999\n2,3\n", 3, "current is not finite"),
        (HEAD + "0,1\n1,2,3\n", 3, "expected 2 columns as in the header, got 3"),
        (HEAD + "0,1,5\n1,2,3\n", 2, "expected 2 columns as in the header, got 3"),
        (HEAD + "0,1\n1\n", 3, "got 1"),
        (HEAD + "0,1\n\n1,2\n", 3, "the line is empty"),
        (HEAD + "0,1\n1,2\n1,3\n", 4, "time does not increase, 1 s is followed by 1 s"),
        (HEAD + "0,1\n1,1_0\n", 3, "not a number"),
        (HEAD + "0,1\n1,\u0661\n", 3, "not a number"),
        (HEAD + "# note\n0,1\n1,2\n", 2, "got 1"),
        (HEAD + "0,1\r1,x\r", 3, "not a number"),
    ],
)
def test_bad_csv_is_refused_with_its_line(
    tmp_path: Path, text: str, line: int, message: str
) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text, encoding="utf-8", newline="")
    with pytest.raises(BadInput, match=message) as caught:
        Recording.read(path)
    assert str(caught.value).startswith(f"{path}, line {line}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("data", [b"time_s,x_A\n0,1\n1,\xff\n", HEAD.encode("utf-16"), b"\0" * 40])
def test_csv_of_unknown_encoding(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "bad.csv").write_bytes(data)
    with pytest.raises(BadInput, match=r"line [13]: "):
        Recording.read(tmp_path / "bad.csv")


def test_absent_folder_unknown_suffix_and_oversize(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    for name in ("absent.csv", "absent.h5", "folder.csv", "file.txt", "file"):
        with pytest.raises(BadInput, match=r"expected"):
            Recording.read(tmp_path / name)
    with pytest.raises(BadInput, match="expected a recording named"):
        example().write(tmp_path / "r.mat")
    example().write(tmp_path / "r.csv.gz")
    with pytest.raises(BadInput, match="longer than 100 bytes"):
        bounded.read_bytes(tmp_path / "r.csv.gz", most=100)


@same_folder
@given(data=st.binary(max_size=60) | st.text("0123456789.,-eE+_sA \n\r\"'#naif").map(str.encode))
def test_any_csv_is_a_recording_or_bad_input(data: bytes, tmp_path: Path) -> None:
    for head in (b"", HEAD.encode(), HEAD.encode() + b"0,1\n"):
        expect_recording_or_bad_input(tmp_path / "r.csv", head + data)
        expect_recording_or_bad_input(tmp_path / "r.csv.gz", gzip.compress(head + data)[:-3])


def expect_recording_or_bad_input(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    try:
        Recording.read(path)
    except BadInput as error:
        assert "\n" not in str(error)


def spoil(change: Callable[[h5py.File], object]) -> bytes:
    """Return the bytes of a good file after `change`."""
    one = example()
    memory = io.BytesIO(hdf5.dump(one.channels, one.units, {"schema": one.schema}))
    with h5py.File(memory, "r+") as file:
        change(file)
    return memory.getvalue()


def put(name: str, **options: object) -> Callable[[h5py.File], object]:
    def change(file: h5py.File) -> None:
        file[f"channels/{name}"] = file["channels"].create_dataset("temporary", **options)
        del file["channels/temporary"]
        file[f"channels/{name}"].attrs["unit"] = np.bytes_("1")

    return change


def link(target: object) -> Callable[[h5py.File], object]:
    return lambda file: file["channels"].__setitem__("x", target)


def layout(file: h5py.File) -> None:
    virtual = h5py.VirtualLayout((50,), "f8")
    virtual[:] = h5py.VirtualSource("/etc/passwd", "x", (50,))
    file["channels"].create_virtual_dataset("x", virtual).attrs["unit"] = np.bytes_("1")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda f: f.attrs.__delitem__("schema"), "schema is missing"),
        (lambda f: f.attrs.__setitem__("schema", np.bytes_("other")), "schema 'other' is unknown"),
        (lambda f: f.attrs.__setitem__("schema", [1.0, 2.0]), "schema .* is not text"),
        (lambda f: f.attrs.__setitem__("plant", "axis"), "plant of .* is text of variable length"),
        (lambda f: f["channels/time"].attrs.__setitem__("unit", "s"), "text of variable length"),
        (lambda f: f.attrs.__setitem__("seed", "x"), "seed is not a whole number"),
        (lambda f: f.attrs.__setitem__("seed", -5), "not a whole number"),
        (lambda f: f.attrs.__setitem__("source", h5py.Empty("S1")), "source .* is not text"),
        (lambda f: f.__delitem__("channels"), 'expected "channels"'),
        (lambda f: f.__delitem__("channels/time"), "time_s"),
        (lambda f: f["channels/time"].attrs.__delitem__("unit"), "lacks the attribute unit"),
        (lambda f: f["channels/time"].attrs.__setitem__("unit", np.bytes_("ms")), "time_s"),
        (lambda f: f["channels"].create_group("deep"), 'expected "deep" to be a dataset'),
        (lambda f: f["channels/time"].write_direct(np.zeros(50)), "time does not increase"),
        (put("x", data=np.full(50, np.nan)), "not finite"),
        (put("x", data=np.zeros(49)), "unequal length"),
        (put("x", data=np.zeros((50, 1))), "1-D float64"),
        (put("x", data=np.zeros(50, "f4")), "1-D float64"),
        (put("x", data=np.zeros(50, "i8")), "1-D float64"),
        (put("x", data=1.0), "1-D float64"),
        (put("x", data=h5py.Empty("f8")), "1-D float64"),
        (put("x", data=[b"a"] * 50, dtype=h5py.string_dtype()), "1-D float64"),
        (put("x", shape=(10**13,), dtype="f8", chunks=(1000,)), "values, more than"),
        (put("x", shape=(50,), dtype="f8", external="/etc/passwd"), "inside this file"),
        (put("x", shape=(50,), dtype="f8", chunks=(50,), scaleoffset=3), "inside this file"),
        (layout, "inside this file"),
        (link(h5py.SoftLink("/channels/time")), "a link"),
        (link(h5py.ExternalLink("/etc/passwd", "/x")), "a link"),
        (put("a b", data=np.zeros(50)), "no channel name"),
    ],
)
def test_foreign_hdf5_is_refused_in_one_line(
    tmp_path: Path, change: Callable[[h5py.File], object], message: str
) -> None:
    path = tmp_path / "bad.h5"
    path.write_bytes(spoil(change))
    with pytest.raises(BadInput, match=message) as caught:
        Recording.read(path)
    assert str(caught.value).startswith(f"{path}: ") and "\n" not in str(caught.value)


def test_accepts_plain_gzip_storage_and_text_of_fixed_length(tmp_path: Path) -> None:
    change = put("x", data=np.ones(50), compression="gzip", shuffle=True, fletcher32=True)
    path = tmp_path / "good.h5"
    path.write_bytes(spoil(change))
    assert Recording.read(path)["x"].tolist() == [1] * 50
    path.write_bytes(spoil(lambda file: file.attrs.__setitem__("plant", np.bytes_("axis"))))
    assert Recording.read(path).plant == "axis"


READ = """
import sys
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
try: Recording.read(sys.argv[1])
except BadInput as error: print(error)
"""


@pytest.mark.parametrize("byte", [b"\0", b"\xff"])
def test_damaged_text_of_variable_length_neither_hangs_nor_crashes(
    tmp_path: Path, byte: bytes
) -> None:
    """HDF5 does both where it reads such text from a damaged heap."""
    whole = spoil(lambda file: file.attrs.__setitem__("plant", "axis"))
    heap = whole.index(b"GCOL")
    path = tmp_path / "bad.h5"
    path.write_bytes(whole[: heap + 8] + 40 * byte + whole[heap + 48 :])
    root = Path(__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", READ, path], capture_output=True, text=True, timeout=60, cwd=root
    )
    assert done.returncode == 0 and "variable length" in done.stdout, done.stderr


def test_damaged_hdf5_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cut.h5"
    replace(example(), experiment="title = 'x'").write(path)
    whole = path.read_bytes()
    for size in (0, 1, 8, 100, 700, 2000, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:size])
        with pytest.raises(BadInput) as caught:
            Recording.read(path)
        why = "it is cut off" if size >= 100 else "it is damaged or of another kind"
        assert str(caught.value) == (
            f"{path}: cannot be read as an HDF5 file, {why}: copy it again, or make it anew"
        )
    flips = np.random.default_rng(1).integers(0, [len(whole), 256], (200, 2))
    for place, byte in flips.tolist():
        expect_recording_or_bad_input(path, whole[:place] + bytes([byte]) + whole[place + 1 :])
    for junk in (b"time_s,x_A\n0,1\n", os.urandom(5000), b"\x89HDF\r\n\x1a\n" + b"\0" * 5000):
        expect_recording_or_bad_input(path, junk)


def test_a_name_in_capitals_is_packed_as_it_is_read(tmp_path):
    example().write(tmp_path / "R.CSV.GZ")
    example().write(tmp_path / "r.csv")
    assert Recording.read(tmp_path / "R.CSV.GZ") == Recording.read(tmp_path / "r.csv")
    assert gzip.decompress((tmp_path / "R.CSV.GZ").read_bytes()).startswith(b"time_s,")
