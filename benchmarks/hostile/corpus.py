"""A small sound file for every reader, of which mutants are made, and how they are made."""

import gzip
import io
import json
import re
import tomllib
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.hostile import nasty
from benchmarks.hostile.nasty import Rng

COUNT = 60  # samples of a seed
TIME = 0.01 * np.arange(COUNT)
ANGLE = 2.0 * (1.0 - np.cos(6.0 * TIME))
COLUMNS = {
    "time": TIME,
    "reference": ANGLE,
    "position": 0.98 * ANGLE,
    "current": 0.3 + 0.1 * np.sin(9.0 * TIME),
}
UNITS = {"time": "s", "reference": "rad", "position": "rad", "current": "A"}
Mutate = Callable[[bytes, Rng], bytes]


def table(columns: dict[str, np.ndarray] = COLUMNS, units: dict[str, str] | None = UNITS) -> str:
    """CSV of columns."""
    names = [f"{n}_{units[n]}" if units else n for n in columns]
    rows = zip(*(each.tolist() for each in columns.values()), strict=True)
    return "\n".join([",".join(names), *(",".join(f"{x:.6g}" for x in row) for row in rows)])


def toml(data: bytes, rng: Rng) -> bytes:
    """Values, keys and order changed; letters in one of ten."""
    import tomli_w

    if rng.random() < 0.1:
        return nasty.octets(data, rng)
    content = nasty.changed(tomllib.loads(data.decode()), rng)
    try:
        return tomli_w.dumps(content).encode("utf-8", "replace")
    except (TypeError, ValueError, AttributeError):
        return nasty.lines(data.decode(), rng, "=").encode()


def as_json(data: bytes, rng: Rng) -> bytes:
    """Values, keys and order changed; bytes in one of ten, nested too deep in one of thirty."""
    kind = rng.random()
    if kind < 0.1:
        return nasty.octets(data, rng)
    if kind < 0.13:
        return data.replace(b": ", b": " + b"[" * nasty.DEEP, 1)
    return json.dumps(nasty.changed(json.loads(data), rng), default=str).encode()


def python(data: bytes, rng: Rng) -> bytes:
    """One to three numbers or texts of Python changed."""
    whole = data.decode()
    for _ in range(rng.integers(1, 4)):
        found = [each.span() for each in re.finditer(r'"[^"\n]*"|\b\d[\d.e-]*\b', whole)]
        start, end = found[rng.integers(0, len(found))]
        text = str(nasty.TEXTS[rng.integers(0, len(nasty.TEXTS))])
        new = repr(
            text if whole[start] == '"' or rng.random() < 0.2 else rng.choice([-1.0, 1e300, 0])
        )
        whole = whole[:start] + new + whole[end:]
    return whole.encode("utf-8", "replace")


def json_lines(data: bytes, rng: Rng) -> bytes:
    """One record of several changed."""
    rows = data.split(b"\n")
    k = int(rng.integers(0, len(rows)))
    rows[k] = as_json(rows[k], rng)
    return b"\n".join(rows)


def text(data: bytes, rng: Rng) -> bytes:
    """Cells, rows and columns changed; bytes in one of ten."""
    if rng.random() < 0.1:
        return nasty.octets(data, rng)
    return nasty.lines(data.decode(), rng).encode("utf-8", "replace")


def packed_text(data: bytes, rng: Rng) -> bytes:
    """The text changed and packed, or the packed bytes changed."""
    if rng.random() < 0.1:
        return nasty.octets(data, rng)
    return gzip.compress(text(gzip.decompress(data), rng), 1)


def hdf5(data: bytes, rng: Rng) -> bytes:
    """Datasets, attributes and links changed; bytes in one of five."""
    import h5py

    if rng.random() < 0.2:
        return nasty.octets(data, rng)
    memory = io.BytesIO(data)
    with h5py.File(memory, "r+") as file:
        names: list[str] = []
        file.visit(names.append)
        for _ in range(rng.integers(1, 3)):
            _change_hdf5(file, names[rng.integers(0, len(names))], rng)
    return memory.getvalue()


def _change_hdf5(file: Any, name: str, rng: Rng) -> None:
    import h5py

    if file.get(name) is None:
        return
    item, kind = file[name], rng.integers(0, 10)
    holder = file if rng.random() < 0.5 else item
    if kind < 3 and len(holder.attrs):
        key = list(holder.attrs)[rng.integers(0, len(holder.attrs))]
        _attribute(holder, key, rng)
    elif kind < 8 and isinstance(item, h5py.Dataset) and item.shape is not None:
        new, attributes = _array(item[()], rng), dict(item.attrs)
        del file[name]
        packed = {"compression": "gzip"} if new.ndim and new.size and rng.random() < 0.3 else {}
        made = file.create_dataset(name, data=new, **packed)
        for key, each in attributes.items():
            if key not in ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST"):
                made.attrs[key] = each
    elif kind == 8:
        del file[name]
        links = (h5py.SoftLink("/nowhere"), h5py.ExternalLink("outside.h5", "/channels/time"),
                 h5py.SoftLink("/" + name), h5py.ExternalLink("/dev/zero", "/"))  # fmt: skip
        file[name] = links[rng.integers(0, len(links))]
    else:
        del file[name]
        file.create_group(name)


def _array(values: Any, rng: Rng) -> np.ndarray:
    if getattr(values, "dtype", None) is not None and values.dtype.names:
        new = values.copy()
        field = new.dtype.names[rng.integers(0, len(new.dtype.names))]
        changed = nasty.samples(new[field], rng)
        if changed.shape == new[field].shape and changed.dtype.kind in "fiub":
            with np.errstate(all="ignore"):
                new[field] = changed
        return new[: int(rng.integers(0, len(new) + 1))] if rng.random() < 0.1 else new
    return nasty.samples(values, rng)


def _attribute(holder: Any, key: str, rng: Rng) -> None:
    import h5py

    new = nasty.value(rng) if rng.random() < 0.7 else nasty.TEXTS[rng.integers(0, len(nasty.TEXTS))]
    old = holder.attrs[key]
    if isinstance(old, str) and len(old) > 20 and rng.random() < 0.8:
        new = (as_json if old[0] in "[{" else toml)(old.encode(), rng).decode("utf-8", "replace")
    try:
        if isinstance(new, str):
            raw = new.encode("utf-8", "replace") or b" "
            holder.attrs.create(key, raw, dtype=h5py.string_dtype("utf-8", len(raw)))
        else:
            holder.attrs[key] = new
    except (TypeError, ValueError, OverflowError, OSError):
        del holder.attrs[key]


def npz(data: bytes, rng: Rng) -> bytes:
    """Arrays changed; bytes in one of five."""
    if rng.random() < 0.2:
        return nasty.octets(data, rng)
    with np.load(io.BytesIO(data)) as found:
        arrays = {name: found[name] for name in found.files}
    name = list(arrays)[rng.integers(0, len(arrays))]
    arrays[name] = nasty.samples(arrays[name], rng)
    memory = io.BytesIO()
    (np.savez_compressed if rng.random() < 0.5 else np.savez)(memory, **arrays)
    return memory.getvalue()


def npy(data: bytes, rng: Rng) -> bytes:
    """A structured array changed, or its head, or bytes."""
    kind = rng.random()
    if kind < 0.2:
        return nasty.octets(data, rng)
    if kind < 0.5:
        head = data[:128].decode("latin-1")
        new = head.replace("60", str(nasty.NUMBERS[rng.integers(0, 15)])[:12]).replace(
            "<f8", rng.choice(["|O", "<c16", "<U9", "<f8"])
        )
        new = new[:8] + new[8:].rstrip("\n ").ljust(119)[:119] + "\n"
        return new.encode("latin-1") + data[128:]
    memory = io.BytesIO()
    np.save(memory, _array(np.load(io.BytesIO(data)), rng))
    return memory.getvalue()


def mat(data: bytes, rng: Rng) -> bytes:
    """Variables changed; bytes in one of five."""
    from scipy.io import loadmat, savemat

    if rng.random() < 0.2:
        return nasty.octets(data, rng)
    content = {
        k: v for k, v in loadmat(io.BytesIO(data), simplify_cells=True).items() if k[0] != "_"
    }
    name = list(content)[rng.integers(0, len(content))]
    content[name] = (
        nasty.samples(content[name], rng)
        if isinstance(content[name], np.ndarray)
        else content[name]
    )
    memory = io.BytesIO()
    savemat(memory, content, do_compression=bool(rng.random() < 0.5))
    return memory.getvalue()


def parquet(data: bytes, rng: Rng) -> bytes:
    """Columns changed; bytes in one of five."""
    import pyarrow
    import pyarrow.parquet

    if rng.random() < 0.2:
        return nasty.octets(data, rng)
    columns = pyarrow.parquet.read_table(io.BytesIO(data)).to_pydict()
    name = list(columns)[rng.integers(0, len(columns))]
    new = nasty.samples(np.array(columns[name], object if rng.random() < 0.1 else float), rng)
    columns[name] = list(new.reshape(-1)) if new.ndim != 2 else [list(row) for row in new]
    if rng.random() < 0.2:
        columns[str(nasty.TEXTS[rng.integers(0, len(nasty.TEXTS))])] = columns.pop(name)
    length = max(map(len, columns.values()))
    columns = {
        n: (list(x) * length)[:length] if len(x) else [None] * length for n, x in columns.items()
    }
    memory = io.BytesIO()
    try:
        pyarrow.parquet.write_table(pyarrow.table(columns), memory)
    except (pyarrow.ArrowException, TypeError, ValueError, OverflowError):
        return nasty.octets(data, rng)
    return memory.getvalue()


def sheet(data: bytes, rng: Rng) -> bytes:
    """Cells of a workbook changed in its XML; bytes in one of ten."""
    if rng.random() < 0.1:
        return nasty.octets(data, rng)
    memory = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(memory, "w") as new:
        for entry in old.infolist():
            content = old.read(entry)
            if "sheet1" in entry.filename or rng.random() < 0.02:
                content = (
                    nasty.lines(content.decode(), rng, ">").encode()
                    if rng.random() < 0.15
                    else _cells(content, rng)
                )
            new.writestr(entry, content)
    return memory.getvalue()


def _cells(content: bytes, rng: Rng) -> bytes:
    parts = content.split(b"<v>")
    if len(parts) < 2:
        return nasty.octets(content, rng)
    for _ in range(rng.integers(1, 4)):
        k = int(rng.integers(1, len(parts)))
        _, mark, rest = parts[k].partition(b"</v>")
        new = (
            nasty.TEXTS[rng.integers(0, len(nasty.TEXTS))]
            if rng.random() < 0.15
            else str(nasty.NUMBERS[rng.integers(0, 20)])
        )
        parts[k] = new.replace("<", "").encode("utf-8", "replace") + mark + rest
    return b"<v>".join(parts)


def mcap(data: bytes, rng: Rng) -> bytes:
    """Records in JSON changed, or bytes."""
    if rng.random() < 0.3:
        return nasty.octets(data, rng)
    records = [json.loads(as_json(json.dumps(each).encode(), rng)) if rng.random() < 0.1 else each
               for each in RECORDS] if rng.random() < 0.9 else []  # fmt: skip
    return mcap_of(records, rng)


def mcap_of(records: list[Any], rng: Rng | None = None) -> bytes:
    """A log of records in JSON."""
    from mcap.writer import CompressionType, Writer

    memory = io.BytesIO()
    kinds = list(CompressionType)
    writer = Writer(
        memory, compression=kinds[rng.integers(0, len(kinds))] if rng is not None else kinds[0]
    )
    writer.start()
    schema = writer.register_schema("State", "jsonschema", b"{}")
    channel = writer.register_channel("/arm", "json", schema)
    for k, each in enumerate(records):
        stamp = 10**9 + 10**7 * k
        if rng is not None and rng.random() < 0.02:
            stamp = int(rng.integers(0, 2**62))
        writer.add_message(channel, stamp, json.dumps(each).encode(), stamp)
    writer.finish()
    return memory.getvalue()


RECORDS: list[Any] = [
    {"t": float(t), "q": {"position": float(x), "current": float(i)}, "ref": float(r)}
    for t, r, x, i in zip(*COLUMNS.values(), strict=True)
]
