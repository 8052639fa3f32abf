"""Bombs whose heads lie about what they unpack to: Parquet, workbooks, ROS logs."""

import bz2
import io
import sqlite3
import struct
import zipfile
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.hostile import bags
from hannes.campaigns.foreign.thrift import Reader

MANY = 1 << 30  # bytes unpacked
Bomb = tuple[str, Callable[[Path], Any], Callable[[Path], None], int]


def all_of(source: Callable[[Path], None]) -> Iterator[Bomb]:
    """These bombs; `source` opens a foreign file."""
    yield "pages.parquet", _parquet, source, 0
    yield "lies.parquet", _lying_parquet, source, 0
    yield "lies.xlsx", _lying_sheet, source, 0
    yield "chunks.bag", _bag, source, 0
    yield "views.db3", _views, source, 0
    yield "whole.zip", _packed_whole, bags.unfolded(source), 0


def _parquet(path: Path) -> None:
    """Half a megabyte that unpacks to a gigabyte, and says so in the heads of its pages alone."""
    import pyarrow
    import pyarrow.parquet

    one = pyarrow.table({"a": np.zeros(10**6)})
    with pyarrow.parquet.ParquetWriter(
        path, one.schema, compression="zstd", use_dictionary=False
    ) as writer:
        for _ in range(MANY // (8 * 10**6)):
            writer.write_table(one)


def _lying_parquet(path: Path) -> None:
    """The same, but its footer states less: sizes of row groups and columns are 7 bytes."""
    _parquet(path)
    data = bytearray(path.read_bytes())
    (length,) = struct.unpack("<I", data[-8:-4])
    start = len(data) - 8 - length
    groups = Reader(bytes(data[start:-8])).fields()[4]
    for group in groups:
        for size in {column[3][6] for column in group[1]}:
            old = _varint(2 * size)
            data[start:-8] = data[start:-8].replace(old, _varint(14, len(old)))
    path.write_bytes(bytes(data))


def _varint(value: int, width: int = 0) -> bytes:
    found = bytearray()
    while value > 127 or len(found) + 1 < width:
        found.append(128 | value & 127)
        value >>= 7
    return bytes([*found, value])


def _lying_sheet(path: Path) -> None:
    """A sheet of 400 MB, of which the archive's directory states a thousand bytes."""
    from benchmarks.hostile.seeds import workbook

    with zipfile.ZipFile(io.BytesIO(workbook())) as old:
        parts = {each.filename: old.read(each) for each in old.infolist()}
    sheet = "xl/worksheets/sheet1.xml"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in parts.items():
            file.writestr(name, content + b" " * (400 * 10**6 - len(content)) * (name == sheet))
    stated = struct.pack("<I", 400 * 10**6)
    path.write_bytes(path.read_bytes().replace(stated, struct.pack("<I", 1000)))


def _bag(path: Path) -> None:
    """A ROS 1 bag with a chunk that unpacks to a gigabyte."""
    packer, whole = bz2.BZ2Compressor(9), io.BytesIO()
    for _ in range(MANY >> 20):
        whole.write(packer.compress(bytes(1 << 20)))
    whole.write(packer.flush())
    chunk = b"".join(map(_field, (b"op=\x05", b"compression=bz2", b"size=\x00\x10\x00\x00")))
    head, _, rest = bags.bag().partition(b"\n")
    path.write_bytes(head + b"\n" + _field(chunk) + _field(whole.getvalue()) + rest)


def _field(content: bytes) -> bytes:
    return struct.pack("<I", len(content)) + content


def _views(path: Path) -> None:
    """Messages that SQLite computes: without end, half a gigabyte each."""
    path.write_bytes(bags.db3())
    with closing(sqlite3.connect(path)) as base:
        base.execute("ALTER TABLE messages RENAME TO old")
        base.execute(
            "CREATE VIEW messages AS WITH RECURSIVE more(id) AS (SELECT 1 UNION ALL SELECT id + 1 "
            "FROM more) SELECT id, 1 AS topic_id, id AS timestamp, zeroblob(500000000) AS data "
            "FROM more"
        )
        base.commit()


def _packed_whole(path: Path) -> None:
    """A rosbag2 whose file is packed as a whole, and unpacks to a gigabyte."""
    import zstandard

    packed = zstandard.ZstdCompressor(19).compressobj()
    data = b"".join(packed.compress(bytes(1 << 20)) for _ in range(MANY >> 20)) + packed.flush()
    with zipfile.ZipFile(io.BytesIO(bags.folder(bags.rosbag2))) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            mine = name.endswith(".db3")
            archive.writestr(f"{name}.zstd" if mine else name, data if mine else content)
