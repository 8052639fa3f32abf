"""Sound files whose samples are no row each: rows of arrays, long, serial."""

import io

import numpy as np

from benchmarks.hostile.corpus import COLUMNS, TIME


def stacked_file() -> bytes:
    """Two runs of each channel beside one clock."""
    memory = io.BytesIO()
    moved = {name: np.stack([x, x]) for name, x in COLUMNS.items() if name != "time"}
    np.savez(memory, time=TIME, **moved)
    return memory.getvalue()


def long_file() -> bytes:
    """A row a value."""
    rows = [
        f"{t!r},{name},{x!r}"
        for name, values in COLUMNS.items()
        if name != "time"
        for t, x in zip(TIME.tolist(), values.tolist(), strict=True)
    ]
    return "\n".join(["time,signal,value", *rows]).encode()


def serial_file() -> bytes:
    """Lines of a serial monitor."""
    rows = zip(*(values.tolist() for values in COLUMNS.values()), strict=True)
    lines = [
        "16:07:41.112 -> " + ",".join(f"{n}:{x!r}" for n, x in zip(COLUMNS, row, strict=True))
        for row in rows
    ]
    return "\n".join(["boot", *lines]).encode()
