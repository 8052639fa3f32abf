"""Every reader of the package: a sound file, its mutants, what is done with one, what it covers.

A reader of hannes that no entry covers fails a test (`missing`): add one for it.
"""

import gzip
import io
import json
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.hostile import bags, corpus, laid_out, raw_logs
from benchmarks.hostile.corpus import COLUMNS, COUNT, RECORDS, TIME, UNITS, Mutate

FOREIGN = "hannes.campaigns.foreign."
CONVERTED = (
    f"{FOREIGN}sources:open_source",
    f"{FOREIGN}to_recordings:read_runs",
)


@dataclass(frozen=True)
class Reader:
    """One reader: `seed` is a sound file's content, `use` reads the file at a path.

    covers: public functions (module:name) that `use` calls; sound: whether it accepts the seed;
    seconds: of processor time that one mutant may take.
    """

    name: str
    ending: str
    seed: Callable[[], bytes]
    mutate: Mutate
    use: Callable[[Path], Any]
    covers: tuple[str, ...]
    sound: bool = True
    seconds: float = 4.0


def recording(path: Path) -> None:
    """Read a recording and look for what is wrong with it, as every verb does."""
    from hannes import Recording
    from hannes.campaigns.check import check
    from hannes.plants.protocol import shipped_plant

    check(Recording.read(path), shipped_plant("hand"))


def dynamometer() -> bytes:
    """A CSV export of a hand dynamometer."""
    rows = [f"{0.01 * k:.2f},{max(0.0, 0.5 * (k - 40)):.2f}" for k in range(120)]
    return "\n".join(['"Latest: Time (s)","Latest: Force (N)"', *rows]).encode()


def use_dynamometer(path: Path) -> None:
    """Read it, and look for its onset."""
    from hannes.bench.dynamometer import read_vernier

    read_vernier(path).onset()


def converted(mapping: str) -> Callable[[Path], None]:
    """Convert through a mapping that aligns its clock."""

    def use(path: Path) -> None:
        from hannes import convert

        where = path.parent / f"{mapping}.mapping.toml"
        convert([path], where)

    return use


def mapping_of(columns: dict[str, str], more: str = "") -> str:
    """A mapping of columns by channel."""
    channels = "".join(
        f'[channels.{name}]\ncolumn = "{column}"\nunit = "{UNITS[name]}"\n'
        for name, column in columns.items()
        if name != "time"
    )
    time = f'[time]\ncolumn = "{columns["time"]}"\nunit = "s"\n'
    align = '[align]\nto = "reference"\nby = "command"\nwithin = "0.1 s"\n'
    return f'plant = "hand"\n{more}{time}{channels}{align}'


LONG = 'long = { names = "signal", values = "value" }\n'
SERIAL = '\n[text]\ndelimiter = "comma"\nstamped = true\npairs = ":"\n'
MAPPINGS = {
    "text": mapping_of({name: name for name in COLUMNS}, 'missing = ["n/a"]\n'),
    "json": mapping_of(
        {"time": "t", "reference": "ref", "position": "q/position", "current": "q/current"}
    ),
    "mcap": mapping_of(
        {
            "time": "arm/time",
            "reference": "arm/ref",
            "position": "arm/q/position",
            "current": "arm/q/current",
        }
    ),
    "long": mapping_of({name: name for name in COLUMNS}, LONG),
    "serial": mapping_of({name: name for name in COLUMNS}) + SERIAL,
    "stacked": mapping_of({name: name for name in COLUMNS}, 'split_at = "stacked"\n'),
    "npy": mapping_of({name: f"data/{name}" for name in COLUMNS}),
    "ROS": mapping_of(
        {"time": "arm/time", **{name: f"arm/position/{name}" for name in bags.JOINTS}}
    ),
    "LeRobot": mapping_of(
        {"time": "timestamp", **{name: f"observation.state/{name}" for name in bags.JOINTS}}
    ),
}


def recording_hdf5() -> bytes:
    """A recording of the hand."""
    from hannes.core.recording import hdf5

    metadata = {"schema": "hannes-recording-1", "plant": "hand", "source": "measured", "seed": 1}
    return hdf5.dump(COLUMNS, UNITS, {**metadata, "experiment": "", "hand": ""})


def plain_hdf5() -> bytes:
    """Datasets in the root, one of them packed."""
    import h5py

    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        for name, values in COLUMNS.items():
            file.create_dataset(name, data=values, compression="gzip" if name == "time" else None)
    return memory.getvalue()


def mat_file(columns: dict[str, np.ndarray]) -> bytes:
    """Variables of a MATLAB file."""
    from scipy.io import savemat

    memory = io.BytesIO()
    savemat(memory, columns)
    return memory.getvalue()


def npz_file() -> bytes:
    """Arrays by name."""
    memory = io.BytesIO()
    np.savez(memory, **COLUMNS)
    return memory.getvalue()


def npy_file() -> bytes:
    """One structured array."""
    memory = io.BytesIO()
    found = np.zeros(COUNT, [(name, "<f8") for name in COLUMNS])
    for name, values in COLUMNS.items():
        found[name] = values
    np.save(memory, found)
    return memory.getvalue()


def parquet_file() -> bytes:
    """One table."""
    import pyarrow
    import pyarrow.parquet

    memory = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table(COLUMNS), memory)
    return memory.getvalue()


def workbook() -> bytes:
    """One sheet."""
    import openpyxl

    book, memory = openpyxl.Workbook(), io.BytesIO()
    sheet = book.active
    sheet.append(list(COLUMNS))
    for row in zip(*(each.tolist() for each in COLUMNS.values()), strict=True):
        sheet.append(row)
    book.save(memory)
    return memory.getvalue()


def rh56() -> bytes:
    """Two trials of a finger."""
    trial = np.repeat([1.0, 2.0], COUNT // 2)
    columns = {"Trial_Index": trial, "Trial_Elapsed_s": TIME, "Middle_Angle": 1000.0 - 9.0 * TIME}
    columns["Middle_Force_g"] = 100.0 * TIME
    return corpus.table(columns, None).encode()


def raw_log() -> bytes:
    """A log of a board that prints lines."""
    head = {"schema": "hannes-raw-log-1", "board": "text", "options": {}, "notes": []}
    found = [json.dumps(head).encode() + b"\n"]
    lines = ["# time_us position_rad current_A"]
    lines += [f"{10000 * k} {x:.5f} 0.1" for k, x in enumerate(COLUMNS["position"])]
    for k, line in enumerate(lines):
        data = line.encode() + b"\n"
        found.append(struct.pack("<QBI", 10**7 * k, 0, len(data)) + data)
    return b"".join(found)


def use_raw_log(path: Path) -> None:
    """Read a raw log and make a recording of it."""
    from hannes.bench.finish import read_rows, recording

    recording(read_rows(path))


def emps(path: Path) -> None:
    """Read a recording of the axis."""
    from hannes.plants.axis.matlab_file import load

    load(path)


def finger(path: Path) -> None:
    """Read the log of a finger."""
    from hannes.plants.finger.rh56_log import is_log, load

    is_log(path)
    load(path)


def begun(path: Path) -> None:
    """Look at a log of unknown layout."""
    from hannes.campaigns.begin.begin import look
    from hannes.plants.protocol import shipped_plant

    look([path], shipped_plant("hand"))


def marks(path: Path) -> None:
    """Ask which verb wrote a file."""
    from hannes.core.io.result_marks import file_verb

    file_verb(path)


_TRAVEL = 0.01 * COLUMNS["reference"]
EMPS = {"t": TIME, "qg": _TRAVEL, "qm": _TRAVEL, "vir": TIME}


def of_data() -> Iterator[Reader]:
    """Readers of recordings, logs and other people's files."""
    csv = corpus.table().encode()
    read = "hannes.core.recording.recording:Recording.read"
    of_csv = ("hannes.core.recording.csv:load", read)
    of_csv = (*of_csv, "hannes.core.recording.recording:Recording.from_csv")
    of_hdf5 = ("hannes.core.recording.hdf5:load",)
    of_hdf5 = (*of_hdf5, "hannes.core.recording.recording:Recording.from_hdf5")
    yield Reader("recording", ".csv", lambda: csv, corpus.text, recording, of_csv)
    yield Reader(
        "packed recording", ".csv.gz", lambda: gzip.compress(csv), corpus.packed_text, recording, ()
    )
    yield Reader("HDF5 recording", ".h5", recording_hdf5, corpus.hdf5, recording, of_hdf5)
    yield from of_foreign_files()
    yield from of_bags()
    yield Reader("unknown log", ".txt", lambda: csv, corpus.text, begun, ())
    yield Reader(
        "finger log", ".csv", rh56, corpus.text, finger, ("hannes.plants.finger.rh56_log:load",)
    )
    yield Reader(
        "EMPS", ".mat", lambda: mat_file(EMPS), corpus.mat, emps,
        ("hannes.plants.axis.matlab_file:load", "hannes.core.recording.matlab:load_mat"),
    )  # fmt: skip
    yield Reader(
        "raw log", ".rawlog", raw_log, raw_logs.raw_log, use_raw_log,
        ("hannes.bench.finish:read_rows",),
    )  # fmt: skip
    yield Reader(
        "dynamometer", ".csv", dynamometer, corpus.text, use_dynamometer,
        ("hannes.bench.dynamometer:read_vernier",),
    )  # fmt: skip
    yield Reader("marks of results", ".h5", recording_hdf5, corpus.hdf5, marks, ())


def of_bags() -> Iterator[Reader]:
    """ROS logs, and folders."""
    ros, folder = converted("ROS"), bags.folder
    in_folder = bags.unfolded(ros)
    yield Reader("ROS 1 bag", ".bag", bags.bag, bags.changed_bag, ros, ())
    yield Reader("rosbag2's SQLite", ".db3", bags.db3, bags.sqlite, ros, ())
    yield Reader("rosbag2", ".zip", lambda: folder(bags.rosbag2), bags.member, in_folder, ())
    yield Reader(
        "rosbag2 in MCAP", ".zip", lambda: folder(bags.rosbag2_in_mcap), bags.member, in_folder, ()
    )
    yield Reader(
        "LeRobot", ".zip", lambda: folder(bags.lerobot), bags.member,
        bags.unfolded(converted("LeRobot")), (),
    )  # fmt: skip


def of_foreign_files() -> Iterator[Reader]:
    """Readers of campaigns/foreign."""
    plain = corpus.table(COLUMNS, None).encode()
    lines = "\n".join(map(json.dumps, RECORDS)).encode()
    text, json_ = converted("text"), converted("json")
    made = (
        ("text", ".log", lambda: plain, corpus.text, text, CONVERTED),
        (
            "JSON",
            ".json",
            lambda: json.dumps(RECORDS).encode(),
            corpus.as_json,
            json_,
            ("json_columns:open_json",),
        ),
        ("JSON lines", ".jsonl", lambda: lines, corpus.json_lines, json_, ()),
        ("foreign HDF5", ".h5", plain_hdf5, corpus.hdf5, text, ("binary_columns:open_hdf5",)),
        (
            "MATLAB",
            ".mat",
            lambda: mat_file(COLUMNS),
            corpus.mat,
            text,
            ("matlab_columns:open_mat",),
        ),
        ("npz", ".npz", npz_file, corpus.npz, text, ("npz_columns:open_npz",)),
        ("runs in rows", ".npz", laid_out.stacked_file, corpus.npz, converted("stacked"), ()),
        ("long table", ".log", laid_out.long_file, corpus.text, converted("long"), ()),
        ("serial monitor", ".log", laid_out.serial_file, corpus.text, converted("serial"), ()),
        ("unknown serial log", ".txt", laid_out.serial_file, corpus.text, begun, ()),
        ("unknown long table", ".txt", laid_out.long_file, corpus.text, begun, ()),
        ("npy", ".npy", npy_file, corpus.npy, converted("npy"), ()),
        (
            "Parquet",
            ".parquet",
            parquet_file,
            corpus.parquet,
            text,
            ("parquet_columns:open_parquet",),
        ),
        ("workbook", ".xlsx", workbook, corpus.sheet, text, ("sheet_columns:open_sheet",)),
        (
            "MCAP",
            ".mcap",
            lambda: corpus.mcap_of(RECORDS),
            corpus.mcap,
            converted("mcap"),
            ("message_columns:open_messages",),
        ),
    )
    for name, ending, seed, mutate, use, covers in made:
        full = tuple(each if "hannes." in each else FOREIGN + each for each in covers)
        yield Reader(name, ending, seed, mutate, use, full)
