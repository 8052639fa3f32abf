"""Every reader of the package: a sound file, its mutants, and what is done with one.

A function of hannes that opens a file and that no entry calls fails a test (`registry`): add one.
"""

import gzip
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from benchmarks.hostile import bags, corpus, laid_out, nasty, raw_logs, seeds
from benchmarks.hostile.corpus import COLUMNS, RECORDS, UNITS, Mutate


@dataclass(frozen=True)
class Reader:
    """One reader: `seed` is a sound file's content, `use` reads the file at a path.

    sound: whether it accepts the seed; seconds: of processor time that one mutant may take.
    """

    name: str
    ending: str
    seed: Callable[[], bytes]
    mutate: Mutate
    use: Callable[[Path], Any]
    sound: bool = True
    seconds: float = 4.0


def recording(path: Path) -> None:
    """Read a recording and look for what is wrong with it, and at the hand that it carries."""
    from hannes import Recording
    from hannes.campaigns.check import check
    from hannes.plants.hand.recorded_hand import hand_of
    from hannes.plants.protocol import shipped_plant

    found = Recording.read(path)
    check(found, shipped_plant("hand"))
    hand_of(found.hand)


def use_dynamometer(path: Path) -> None:
    """Read it, and look for its onset."""
    from hannes.bench.dynamometer import read_vernier

    read_vernier(path).onset()


def long_text(arrow: bool) -> Callable[[Path], None]:
    """Convert a text file as a long one is read: whole, by Arrow or by numpy."""
    use = converted("text")

    def used(path: Path) -> None:
        from hannes.campaigns.foreign import plain_table

        without = {} if arrow else {"find_spec": lambda name: None}
        with mock.patch.multiple(plain_table, SHORT=0, **without):
            use(path)

    return used


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


def use_raw_log(path: Path) -> None:
    """Read a raw log and make a recording of it."""
    from hannes.bench.finish import read_rows, recording

    recording(read_rows(path))


def emps(path: Path) -> None:
    """Read a recording of the axis."""
    from hannes import convert

    convert([path], "emps")


def finger(path: Path) -> None:
    """Read the log of a finger."""
    from hannes import convert

    convert([path], "rh56")


def begun(path: Path) -> None:
    """Look at a log of unknown layout."""
    from hannes.campaigns.begin.begin import look
    from hannes.plants.protocol import shipped_plant

    look([path], shipped_plant("hand"))


def marks(path: Path) -> None:
    """Ask which verb wrote a file."""
    from hannes.core.io.result_marks import file_verb

    file_verb(path)


def marks_beside(path: Path) -> None:
    """Ask which verb wrote a CSV, beside which a file says so."""
    csv = path.with_name(path.name.removesuffix(".hannes.json").removesuffix(".conversion.json"))
    csv.write_bytes(corpus.table().encode())
    marks(path)
    marks(csv)
    csv.unlink()


def marks_of_folder(path: Path) -> None:
    """Ask which of a folder's files are results, and whether they are as they were written."""
    from hannes.core.io.result_marks import MARKER, changed, folder_mark, foreign

    (path.parent / MARKER).write_bytes(path.read_bytes())
    try:
        if mark := folder_mark(path.parent):
            foreign(path.parent, mark)
            changed(path.parent, mark)
    finally:
        (path.parent / MARKER).unlink()


def of_data() -> Iterator[Reader]:
    """Readers of recordings, logs and other people's files."""
    csv = corpus.table().encode()
    plain = corpus.table(COLUMNS, None).encode()
    yield Reader("recording", ".csv", lambda: csv, corpus.text, recording)
    yield Reader(
        "packed recording", ".csv.gz", lambda: gzip.compress(csv), corpus.packed_text, recording
    )
    yield Reader("HDF5 recording", ".h5", seeds.recording_hdf5, corpus.hdf5, recording)
    yield from of_foreign_files()
    yield Reader("long text", ".log", lambda: plain, corpus.text, long_text(arrow=True))
    yield Reader("long text by numpy", ".log", lambda: plain, corpus.text, long_text(arrow=False))
    yield from of_bags()
    yield Reader("unknown log", ".txt", lambda: csv, corpus.text, begun)
    yield Reader("finger log", ".csv", seeds.rh56, corpus.text, finger)
    yield Reader("EMPS", ".mat", lambda: seeds.mat_file(seeds.EMPS), corpus.mat, emps)
    lines, servo, frames = raw_logs.of_lines, raw_logs.of_servo, raw_logs.of_frames
    yield Reader("raw log", ".rawlog", lines, raw_logs.raw_log, use_raw_log)
    yield Reader("raw log of a servo", ".rawlog", servo, raw_logs.raw_log, use_raw_log)
    yield Reader("raw log of frames", ".rawlog", frames, raw_logs.framed, use_raw_log)
    yield Reader("dynamometer", ".csv", seeds.dynamometer, corpus.text, use_dynamometer)
    yield from of_marks()


def of_marks() -> Iterator[Reader]:
    """What says which verb wrote a result, where anybody's file may lie."""
    results, octets = seeds.marks_of_folder, nasty.octets
    beside, former = seeds.mark_beside, seeds.conversion
    yield Reader("marks of results", ".h5", seeds.recording_hdf5, corpus.hdf5, marks)
    yield Reader("marks of a folder", ".json", results, corpus.as_json, marks_of_folder)
    yield Reader("mark of a CSV", ".csv.hannes.json", beside, corpus.as_json, marks_beside)
    yield Reader("former mark", ".csv.conversion.json", former, corpus.as_json, marks_beside)
    yield Reader("mark of an FMU", ".fmu", seeds.fmu, octets, marks)
    yield Reader("mark of a page", ".html", lambda: b"<!-- hannes view -->", octets, marks)


def of_bags() -> Iterator[Reader]:
    """ROS logs, and folders."""
    ros, folder = converted("ROS"), bags.folder
    in_folder, of_lerobot = bags.unfolded(ros), bags.unfolded(converted("LeRobot"))
    in_mcap = bags.rosbag2_in_mcap
    yield Reader("ROS 1 bag", ".bag", bags.bag, bags.changed_bag, ros)
    yield Reader("rosbag2's SQLite", ".db3", bags.db3, bags.sqlite, ros)
    yield Reader("rosbag2", ".zip", lambda: folder(bags.rosbag2), bags.member, in_folder)
    yield Reader("rosbag2 in MCAP", ".zip", lambda: folder(in_mcap), bags.member, in_folder)
    packed = bags.rosbag2_packed
    yield Reader("packed rosbag2", ".zip", lambda: folder(packed), bags.member, in_folder)
    yield Reader("LeRobot", ".zip", lambda: folder(bags.lerobot), bags.member, of_lerobot)


def of_foreign_files() -> Iterator[Reader]:
    """Readers of campaigns/foreign."""
    plain = corpus.table(COLUMNS, None).encode()
    whole, lines = json.dumps(RECORDS).encode(), "\n".join(map(json.dumps, RECORDS)).encode()
    text, json_, serial, long = map(converted, ("text", "json", "serial", "long"))
    yield Reader("text", ".log", lambda: plain, corpus.text, text)
    yield Reader("JSON", ".json", lambda: whole, corpus.as_json, json_)
    yield Reader("JSON lines", ".jsonl", lambda: lines, corpus.json_lines, json_)
    yield Reader("foreign HDF5", ".h5", seeds.plain_hdf5, corpus.hdf5, text)
    yield Reader("MATLAB", ".mat", lambda: seeds.mat_file(COLUMNS), corpus.mat, text)
    yield Reader("npz", ".npz", seeds.npz_file, corpus.npz, text)
    yield Reader("npy", ".npy", seeds.npy_file, corpus.npy, converted("npy"))
    yield Reader("Parquet", ".parquet", seeds.parquet_file, corpus.parquet, text)
    yield Reader("workbook", ".xlsx", seeds.workbook, corpus.sheet, text)
    records = corpus.mcap_of(RECORDS)
    yield Reader("MCAP", ".mcap", lambda: records, corpus.mcap, converted("mcap"))
    yield Reader("runs in rows", ".npz", laid_out.stacked_file, corpus.npz, converted("stacked"))
    yield Reader("long table", ".log", laid_out.long_file, corpus.text, long)
    yield Reader("serial monitor", ".log", laid_out.serial_file, corpus.text, serial)
    yield Reader("unknown serial log", ".txt", laid_out.serial_file, corpus.text, begun)
    yield Reader("unknown long table", ".txt", laid_out.long_file, corpus.text, begun)
