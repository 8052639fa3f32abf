"""Arrays as text that a page carries: whole multiples of a quantum, or floats, deflated."""

import base64
import zlib
from typing import Any

import numpy as np


def whole(values: np.ndarray, quantum: float) -> dict[str, Any]:
    """Pack rows over time, shape (n, ...), as whole multiples of `quantum`; error half a quantum.

    Differences from row to row, byte planes apart: smooth motion deflates to little.
    """
    counts = np.rint(values.reshape(len(values), -1) / quantum).astype("<i4")
    steps = np.diff(counts, axis=0, prepend=np.zeros((1, counts.shape[1]), "<i4"))
    content = _deflated(steps.T.astype("<i4"))
    return {"kind": "whole", "rows": len(values), "quantum": quantum, "data": content}


def exact(values: np.ndarray) -> dict[str, Any]:
    """Pack one channel, shape (n,), with all of its bits."""
    return {"kind": "exact", "rows": len(values), "data": _deflated(values.astype("<f8"))}


def unpacked(packed: dict[str, Any]) -> np.ndarray:
    """What the page makes of it: shape (n, columns) of whole numbers, (n,) of exact ones."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), np.uint8)
    size, kind = (4, "<i4") if packed["kind"] == "whole" else (8, "<f8")
    values = planes.reshape(size, -1).T.copy().view(kind).ravel()
    if packed["kind"] == "exact":
        return values
    steps = values.reshape(-1, packed["rows"])
    return np.cumsum(steps, axis=1).T * packed["quantum"]


def _deflated(values: np.ndarray) -> str:
    """Byte planes of an array, most of them nearly empty, deflated, in base 64."""
    content = np.ascontiguousarray(values)
    planes = content.view(np.uint8).reshape(-1, content.itemsize).T
    return base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")
