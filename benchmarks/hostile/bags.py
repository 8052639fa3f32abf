"""ROS logs and folders of files, and how they are changed.

A folder is handed on as a ZIP archive of its files, which `unfolded` lays down beside it.
"""

import io
import json
import shutil
import sqlite3
import tempfile
import zipfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.hostile import corpus, nasty
from benchmarks.hostile.corpus import ANGLE, COLUMNS, COUNT, TIME
from benchmarks.hostile.nasty import Rng

STATES = "sensor_msgs/msg/JointState"
JOINTS = ("reference", "position", "current")  # each a joint, of which `position` is read
MEMBERS = {".json": corpus.as_json, ".parquet": corpus.parquet}


def folder(write: Callable[[Path], None]) -> bytes:
    """A ZIP archive of what `write` writes into a folder."""
    memory = io.BytesIO()
    with tempfile.TemporaryDirectory() as place, zipfile.ZipFile(memory, "w") as archive:
        top = Path(place) / "folder"
        write(top)
        for each in sorted(top.rglob("*")):
            if each.is_file():
                archive.write(each, each.relative_to(top).as_posix())
    return memory.getvalue()


def unfolded(use: Callable[[Path], Any]) -> Callable[[Path], None]:
    """Use the folder that lies in an archive."""

    def used(path: Path) -> None:
        place = path.with_name("mutant_folder")
        shutil.rmtree(place, ignore_errors=True)
        try:
            with zipfile.ZipFile(path) as archive:
                archive.extractall(place)
        except zipfile.BadZipFile:  # what bombs.use_small gives
            place.mkdir(exist_ok=True)
        try:
            use(place)
        finally:
            shutil.rmtree(place, ignore_errors=True)

    return used


def member(data: bytes, rng: Rng) -> bytes:
    """One file of a folder changed, by its kind; one in twenty is left out."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    name = list(files)[rng.integers(0, len(files))]
    mutate = {".yaml": yaml, ".db3": sqlite, ".mcap": _message, ".zstd": packed, **MEMBERS}[
        Path(name).suffix
    ]
    files[name] = mutate(files[name], rng)
    if rng.random() < 0.05:
        del files[name]
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        for each, content in files.items():
            archive.writestr(each, content)
    return memory.getvalue()


def packed(data: bytes, rng: Rng) -> bytes:
    """What is packed changed, or its bytes in one of five."""
    import zstandard

    if rng.random() < 0.2:
        return nasty.octets(data, rng)
    with zstandard.ZstdDecompressor().stream_reader(data) as stream:
        return zstandard.ZstdCompressor().compress(sqlite(stream.read(), rng))


def yaml(data: bytes, rng: Rng) -> bytes:
    """Values of a YAML file changed."""
    return nasty.lines(data.decode(), rng, ": ").encode("utf-8", "replace")


def lerobot(place: Path) -> None:
    """A LeRobot data set of one episode, its columns in one vector."""
    import pyarrow
    import pyarrow.parquet

    names = list(JOINTS)
    state = {"dtype": "float32", "shape": [3], "names": names}
    info = {"codebase_version": "v3.0", "fps": 100, "features": {"observation.state": state}}
    (place / "meta").mkdir(parents=True)
    (place / "meta" / "info.json").write_text(json.dumps(info))
    rows = np.column_stack([COLUMNS[name] for name in names])
    columns = {"timestamp": TIME, "observation.state": rows.tolist()}
    (place / "data" / "chunk-000").mkdir(parents=True)
    pyarrow.parquet.write_table(
        pyarrow.table(columns), place / "data" / "chunk-000" / "file-000.parquet"
    )


def _messages(store: Any, columns: dict[str, np.ndarray], names: list[str]) -> list[Any]:
    types = store.types
    stamp = types["builtin_interfaces/msg/Time"]
    more = {"seq": 0} if "seq" in _fields(types["std_msgs/msg/Header"]) else {}
    return [
        types[STATES](
            header=types["std_msgs/msg/Header"](
                stamp=stamp(sec=50 + int(t), nanosec=round(1e9 * (t % 1.0))), frame_id="", **more
            ),
            name=names,
            position=np.array([columns[each][k] for each in JOINTS], np.float64),
            velocity=np.zeros(len(JOINTS)),
            effort=np.zeros(len(JOINTS)),
        )
        for k, t in enumerate(TIME)
    ]


def _fields(kind: Any) -> Any:
    return getattr(kind, "__dataclass_fields__", {})


def _stamp(k: int) -> int:
    return 50 * 10**9 + 10**7 * k


def rosbag2(place: Path, mcap: bool = False, packed: bool = False) -> None:
    """A rosbag2 of joint states, in SQLite or MCAP; its file packed as a whole."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    writer = Writer(place, version=9, storage_plugin=plugin)
    if packed:
        writer.set_compression(CompressionMode.FILE, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/arm", STATES, typestore=store)
        for k, each in enumerate(_messages(store, COLUMNS, list(JOINTS))):
            writer.write(connection, _stamp(k), store.serialize_cdr(each, STATES))


def rosbag2_in_mcap(place: Path) -> None:
    """A rosbag2 in MCAP."""
    rosbag2(place, mcap=True)


def rosbag2_packed(place: Path) -> None:
    """A rosbag2 whose file is packed as a whole."""
    rosbag2(place, packed=True)


def db3() -> bytes:
    """The SQLite file of a rosbag2."""
    with zipfile.ZipFile(io.BytesIO(folder(rosbag2))) as archive:
        (name,) = (each for each in archive.namelist() if each.endswith(".db3"))
        return archive.read(name)


def sqlite(data: bytes, rng: Rng) -> bytes:
    """Rows of a SQLite file changed, a table, or bytes in one of five."""
    if rng.random() < 0.2:
        return nasty.octets(data, rng)
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "mutant.db3"
        path.write_bytes(data)
        with closing(sqlite3.connect(path)) as base:
            for _ in range(rng.integers(1, 4)):
                _change_sqlite(base, rng)
            base.commit()
        return path.read_bytes()


def _change_sqlite(base: sqlite3.Connection, rng: Rng) -> None:
    kind, row = rng.random(), int(rng.integers(1, COUNT + 1))
    if kind < 0.45:
        (old,) = base.execute("SELECT data FROM messages WHERE id = ?", (row,)).fetchone() or (
            b"x",
        )
        base.execute("UPDATE messages SET data = ? WHERE id = ?", (_message(old, rng), row))
    elif kind < 0.6:
        stamp = int(rng.choice([0, -1, 2**62, _stamp(row) + 1, 1]))
        base.execute("UPDATE messages SET timestamp = ? WHERE id = ?", (stamp, row))
    elif kind < 0.8:
        column = str(rng.choice(["name", "type", "serialization_format", "offered_qos_profiles"]))
        text = nasty.TEXTS[rng.integers(0, len(nasty.TEXTS))].encode("utf-8", "replace").decode()
        base.execute(f"UPDATE topics SET {column} = ?", (text,))
    elif kind < 0.9:
        base.execute("DELETE FROM messages WHERE id = ?", (row,))
    else:
        base.execute(f"CREATE VIEW more{rng.integers(0, 10**9)} AS SELECT * FROM messages")


def _message(old: Any, rng: Rng) -> bytes:
    """A message with a number, a length or its end changed."""
    new = bytearray(old if isinstance(old, bytes) else b"x")
    if rng.random() < 0.6 and len(new) > 120:
        at = int(rng.integers(60, len(new) - 8))
        new[at : at + 8] = np.float64(nasty.NUMBERS[rng.integers(0, 7)]).tobytes()
        return bytes(new)
    return nasty.octets(bytes(new), rng)


def bag(rng: Rng | None = None) -> bytes:
    """A ROS 1 bag of joint states, some of its values changed."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    columns, names, topic = dict(COLUMNS), list(JOINTS), "/arm"
    if rng is not None:
        name = JOINTS[rng.integers(0, len(JOINTS))]
        new = nasty.samples(columns[name], rng)
        if new.shape == ANGLE.shape and new.dtype.kind in "fiub":
            columns[name] = new
        if rng.random() < 0.2:
            names[rng.integers(0, len(names))] = "".join(
                each
                for each in nasty.TEXTS[rng.integers(0, len(nasty.TEXTS))]
                if each.isprintable()
            )
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "made.bag"
        writer = Writer(path)
        if rng is not None and rng.random() < 0.5:
            kinds = list(Writer.CompressionFormat)
            writer.set_compression(kinds[rng.integers(0, len(kinds))])
        with writer:
            connection = writer.add_connection(topic, STATES, typestore=store)
            for k, each in enumerate(_messages(store, columns, names)):
                stamp = _stamp(k)
                if rng is not None and rng.random() < 0.01:
                    stamp = int(rng.integers(0, 2**61))
                writer.write(connection, stamp, store.serialize_ros1(each, STATES))
        return path.read_bytes()


def changed_bag(data: bytes, rng: Rng) -> bytes:
    """Messages of a bag changed, or bytes in one of three."""
    return nasty.octets(data, rng) if rng.random() < 0.33 else bag(rng)
