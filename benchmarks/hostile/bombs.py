"""Files that would take gigabytes, or never end: refused soon, with little memory."""

import gzip
import io
import multiprocessing
import os
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import Row
from benchmarks.hostile import corpus, models, packed_bombs, seeds, tomls
from benchmarks.hostile.readers import MAPPINGS, recording, use_raw_log
from benchmarks.hostile.worker import A_BYTE, ABOVE, _resident
from hannes.core.errors import BadInput
from hannes.core.io import bounded
from hannes.core.io.limits import VALUES

LARGE = (
    "endless.csv.gz", "zeros.npz", "zeros.xlsx", "zeros.mat", "block.h5", "pages.parquet",
    "lies.parquet", "lies.xlsx", "chunks.bag", "whole.zip",
)  # long to write  # fmt: skip
SECONDS = 30.0  # of processor time, reading up to the limit included
AFTER = 2.0  # s of processor time after the last block below the limit was read
Bomb = tuple[str, Callable[[Path], Any], Callable[[Path], None], int]  # ..., decoded bytes


def measured(folder: Path, quick: bool = False) -> tuple[list[Row], int]:
    """A row for each bomb, and how many were read, or broke a limit; `quick`: without LARGE."""
    chosen = (each for each in _bombs() if not quick or each[0] not in LARGE)
    rows = [_row(folder / name, write, use, decoded) for name, write, use, decoded in chosen]
    return rows, sum(bool(row["wrong"]) for row in rows)


def _row(path: Path, write: Callable[[Path], Any], use: Callable[[Path], None], size: int) -> Row:
    write(path)
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_use, args=(path, use, there))
    process.start()
    there.close()
    try:
        outcome, seconds, after, grown = (
            here.recv() if here.poll(120.0) else ("hung", 120.0, 120.0, 0)
        )
    except EOFError:
        outcome, seconds, after, grown = "crashed", 0.0, 0.0, 0
    process.kill()
    process.join()
    packed = path.stat().st_size if path.is_file() else 0
    path.unlink()
    wrong = not outcome.startswith("refused") or grown > ABOVE + A_BYTE * size or seconds > SECONDS
    wrong = wrong or after > AFTER
    return {
        "reader": f"bomb {path.name}",
        "bytes": packed,
        "MiB": round(grown / 2**20, 1),
        "s": round(seconds, 2),
        "s after": round(after, 2),
        "wrong": int(wrong),
        "the first": outcome[:160],
    }


def _use(path: Path, use: Callable[[Path], None], pipe: Any) -> None:
    outcome = "read"
    use_small(path, use)
    last = _last_block()
    held, begun = _resident("VmRSS"), time.process_time()
    Path("/proc/self/clear_refs").write_text("5")
    try:
        use(path)
    except BadInput as error:
        outcome = f"refused: {str(error).replace(str(path.parent), '')}"
    except BaseException as error:
        outcome = f"{type(error).__name__}: {error}"
    ended = time.process_time()
    pipe.send((outcome, ended - begun, ended - max(begun, last[0]), _resident("VmHWM") - held))


def _last_block() -> list[float]:
    """When the last block of a file was handed to its reader [s of processor time].

    That is when a limit on what was decoded is reached; other limits are reached before.
    """
    last, blocks = [0.0], bounded.blocks

    def stamped(*given: Any, **how: Any) -> Iterator[bytes]:
        for each in blocks(*given, **how):
            last[0] = time.process_time()
            yield each

    bounded.blocks = stamped
    return last


def use_small(path: Path, use: Callable[[Path], None]) -> None:
    """Import what the reader needs, with a file that is no bomb."""
    small = path.with_name(f"small{''.join(path.suffixes)}")
    small.write_bytes(b"nothing")
    try:
        use(small)
    except BadInput:
        pass
    small.unlink()


def source(path: Path) -> None:
    """Open a foreign file, and look at every column."""
    from hannes.campaigns.foreign.binary_columns import Arrays
    from hannes.campaigns.foreign.mapping import Column, TextRule
    from hannes.campaigns.foreign.sources import open_source

    found = open_source(path, TextRule(), ())
    for name in found.names if isinstance(found, Arrays) else ():
        found.numbers(Column(name))


def _bombs() -> Iterator[Bomb]:
    yield from _of_other_kinds()
    rows = _written(lambda: _packed(b"0,0\n" * 10**5, 260, b"time_s,x_1\n"))
    yield "zeros.csv.gz", _written(lambda: _packed(b"\n" * 10**6, 92)), recording, 0
    yield "endless.csv.gz", rows, recording, 4 * VALUES // 2
    yield "wide.csv", _written(lambda: _wide(100_000)), recording, 0
    yield "wide.log", _written(lambda: _wide(100_000)), source, 600_000
    yield "one_line.csv", _written(lambda: b"time_s,x_1\n" + b"1" * 10**7), recording, 0
    yield "zeros.npz", _npz, source, 0
    yield "zeros.xlsx", _xlsx, source, 0
    yield "sparse.json", _written(_sparse), source, 10**7
    yield "zeros.mat", _mat, source, 512 << 20
    yield "block.h5", _block, recording, 0
    yield "claims.h5", _claims, recording, 0
    yield "claims_set.h5", _set, tomls.data_set, 0
    yield "outside.h5", _outside, recording, 0
    yield from packed_bombs.all_of(source)
    yield "long.toml", _written(lambda: b"a = [" + b"1," * 6_000_000 + b"]"), tomls.hand, 12 * 10**6
    yield "full.toml", _written(lambda: b"a = [" + b"1," * 199_990 + b"]"), tomls.hand, 4 * 10**5
    yield "deep.toml", _written(lambda: b"a = " + b"[" * 390_000), tomls.hand, 0
    yield "deep.json", _written(lambda: b"[" * 10**7), source, 0
    yield "deep.rawlog", _written(lambda: b"[" * 10**7), use_raw_log, 0
    yield "skip.toml", _written(_skip), tomls.mapping, 0
    yield "keys.toml", _written(lambda: b"[" + b"a." * 10**6 + b"a]"), tomls.hand, 2 * 10**6


def _skip() -> bytes:
    """A mapping with a pattern of time that is exponential in the length of a line."""
    return (MAPPINGS["text"] + "[text]\nskip = '(a+)+$'\n").encode()


def _written(content: Callable[[], bytes]) -> Callable[[Path], Any]:
    return lambda path: path.write_bytes(content())


def _of_other_kinds() -> Iterator[Bomb]:
    """Named pipes, and devices behind links."""
    pipes = {".csv": recording, ".h5": recording, ".toml": tomls.hand}
    for ending, use in {**pipes, ".json": source, ".npz": source, ".mat": source}.items():
        yield f"pipe{ending}", os.mkfifo, use, 0
    zeros = {".toml": tomls.experiment, ".csv": recording, ".log": source}
    for ending, use in {**zeros, ".mcap": source, ".parquet": source}.items():
        yield f"zero{ending}", lambda path: path.symlink_to("/dev/zero"), use, 0


def _packed(block: bytes, count: int, head: bytes = b"") -> bytes:
    memory = io.BytesIO()
    with gzip.GzipFile(fileobj=memory, mode="wb", compresslevel=9) as file:
        file.write(head)
        for _ in range(count):
            file.write(block)
    return memory.getvalue()


def _wide(count: int) -> bytes:
    head = ",".join(["time_s", *(f"c{k}_1" for k in range(count))])
    row = ",".join(["0"] * (count + 1))
    return f"{head}\n{row}\n{row}\n".encode()


def _npz(path: Path) -> None:
    zeros = np.zeros(60_000_000, np.float64)
    np.savez_compressed(path, data=zeros)


def _xlsx(path: Path) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        with file.open("xl/sharedStrings.xml", "w", force_zip64=True) as part:
            for _ in range(300):
                part.write(b" " * (1 << 20))


def _sparse() -> bytes:
    head = "{" + ",".join(f'"c{k}":1' for k in range(1900)) + "}"
    return f"[{head}{',{}' * 3_000_000}]".encode()


def _mat(path: Path) -> None:
    packed = zlib.compressobj(9)
    data = b"".join(packed.compress(b"\0" * (1 << 20)) for _ in range(600)) + packed.flush()
    head = b"MATLAB 5.0".ljust(124) + b"\x00\x01IM"
    path.write_bytes(head + np.array([15, len(data)], "<u4").tobytes() + data)


def _block(path: Path) -> None:
    """A channel whose one block unpacks to a gigabyte instead of its 16 MB."""
    import h5py

    path.write_bytes(seeds.recording_hdf5())
    packed = zlib.compressobj(9)
    data = b"".join(packed.compress(b"\0" * (1 << 20)) for _ in range(1000)) + packed.flush()
    with h5py.File(path, "r+") as file:
        for name in list(file["channels"]):
            unit = file["channels"][name].attrs["unit"]
            del file["channels"][name]
            made = file["channels"].create_dataset(
                name, (2_000_000,), "<f8", chunks=(2_000_000,), compression="gzip"
            )
            made.attrs["unit"] = unit
            made.id.write_direct_chunk((0,), data)


def _claims(path: Path) -> None:
    import h5py

    path.write_bytes(seeds.recording_hdf5())
    with h5py.File(path, "r+") as file:
        for name in list(file["channels"]):
            del file["channels"][name]
            file["channels"].create_dataset(name, (12_000_000,), "<f8", chunks=(1000,))


def _set(path: Path) -> None:
    """A data set of two megabytes that unpacks to gigabytes."""
    import h5py

    path.write_bytes(models.data_set_bytes())
    with h5py.File(path, "r+") as file:
        rows = np.repeat(file["grasps"][()], 2000)
        del file["grasps"]
        file.create_dataset("grasps", data=rows, compression="gzip")
        for name in ("reference", "position", "current", "force"):
            del file[f"channels/{name}"]
            made = file.create_dataset(
                f"channels/{name}", (rows.size, corpus.COUNT * 100), "<f4",
                chunks=(100, corpus.COUNT * 100), compression="gzip",
            )  # fmt: skip
            packed = zlib.compress(bytes(400 * corpus.COUNT * 100), 9)
            for k in range(0, rows.size, 100):
                made.id.write_direct_chunk((k, 0), packed)
        del file["channels/time"]
        file["channels/time"] = 0.001 * np.arange(corpus.COUNT * 100)


def _outside(path: Path) -> None:
    import h5py

    path.write_bytes(seeds.recording_hdf5())
    with h5py.File(path, "r+") as file:
        del file["channels/current"]
        file["channels/current"] = h5py.ExternalLink("recording.h5", "/channels/current")
