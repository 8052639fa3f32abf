"""Arrays and trees as C constants that give back the same bits."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.recognition.forest import Forest

LEFT_LEAF, RIGHT_LEAF = 128, 64  # beside a node's feature: its child is a leaf
MOST_FEATURES = RIGHT_LEAF
SMALL = 1 << 16  # numbers that 16 bits hold
WIDTH = 100


@dataclass(frozen=True)
class CForest:
    """A forest as C constants: their text, their bytes, how many trees and nodes."""

    text: str
    table_bytes: int
    trees: int
    nodes: int


@dataclass(frozen=True)
class Packed:
    """Trees as inner nodes and leaves, both in preorder, a left child next to its parent.

    starts (trees + 1,): first inner node of each tree; feature with LEFT_LEAF and RIGHT_LEAF,
    threshold, and `left`, the inner nodes under the left child, (inner,); values (leaves,). A tree
    has one leaf more than inner nodes: the place of a leaf follows from the way to it.
    """

    starts: np.ndarray
    feature: np.ndarray
    threshold: np.ndarray
    left: np.ndarray
    values: np.ndarray


def is_single(forest: Forest) -> bool:
    """Whether floats hold the values of all leaves."""
    return np.array_equal(forest.value.astype(np.float32), forest.value)


def c_forest(name: str, forest: Forest, leaf: str = "double") -> CForest:
    """Trees of `forest` as a `struct HannesForest hannes_<name>`; `leaf`: C type of a value."""
    packed, own = pack(forest), f"hannes_{name}"
    values, place = np.unique(packed.values, return_inverse=True)
    wide, write = (4, short) if leaf == "float" else (8, number)
    shared = values.size <= SMALL and wide * values.size + 2 * place.size < wide * place.size
    table = values if shared else packed.values
    far = packed.left.max(initial=0) >= SMALL
    parts = {
        "start": array("uint32_t", f"{own}_start", map(str, packed.starts)),
        "feature": array("uint8_t", f"{own}_feature", map(str, packed.feature)),
        "threshold": array("float", f"{own}_threshold", map(short, packed.threshold)),
        "value": array(leaf, f"{own}_value", map(write, table)),
    }
    left = "far" if far else "left"
    parts[left] = array(f"uint{32 if far else 16}_t", f"{own}_{left}", map(str, packed.left))
    if shared:
        parts["place"] = array("uint16_t", f"{own}_place", map(str, place))
    trees, inner, leaves = packed.starts.size - 1, packed.left.size, packed.values.size
    fields = "".join(f", .{part} = {own}_{part}" for part in parts)
    text = "\n".join(
        [
            *parts.values(),
            f"static const struct HannesForest {own} = {{.trees = {trees}u{fields}}};",
        ]
    )
    size = 4 * (trees + 1) + (9 if far else 7) * inner + wide * table.size + 2 * leaves * shared
    return CForest(text, size, trees, inner + leaves)


def pack(forest: Forest) -> Packed:
    """The same trees, leaves of one value under one node joined."""
    left, right, feature = (x.tolist() for x in (forest.left, forest.right, forest.feature))
    if forest.feature.max(initial=0) >= MOST_FEATURES:
        raise BadInput(f"trees ask for more than {MOST_FEATURES} features")
    threshold, value = below(forest.threshold), forest.value.tolist()
    out: dict[str, list[float]] = {name: [] for name in ("feature", "threshold", "left", "values")}
    starts = []
    for start, end in zip(forest.starts[:-1].tolist(), forest.starts[1:].tolist(), strict=True):
        joined = _joined(start, end, left, right, value)
        starts.append(len(out["left"]))
        _walk(start, joined, (left, right, feature, threshold, value), out)
    return Packed(
        np.array([*starts, len(out["left"])]),
        np.array(out["feature"], np.uint8),
        np.array(out["threshold"], np.float32),
        np.array(out["left"], np.int64),
        np.array(out["values"], float),
    )


def _joined(
    start: int, end: int, left: list[int], right: list[int], value: list[float]
) -> list[bool]:
    """Which nodes of a tree count as leaves: those, and those over leaves of one value alone."""
    leaf = [True] * (end - start)
    for node in range(end - start - 1, -1, -1):  # children come after their parents
        low, high = left[start + node], right[start + node]
        if low < 0:
            continue
        same = leaf[low] and leaf[high] and value[start + low] == value[start + high]
        leaf[node] = same
        if same:
            value[start + node] = value[start + low]
    return leaf


def _walk(start: int, leaf: list[bool], tree: Any, out: dict[str, list[float]]) -> None:
    """Append a tree's inner nodes and leaves in preorder."""
    left, right, feature, threshold, value = tree
    waiting: list[tuple[int, int]] = [(0, -1)]  # node, and the inner node to whose right it is
    while waiting:
        node, parent = waiting.pop()
        at = start + node
        if parent >= 0:
            out["left"][parent] = len(out["left"]) - parent - 1
        if leaf[node]:
            out["values"].append(value[at])
            continue
        low, high = left[at], right[at]
        flags = LEFT_LEAF * leaf[low] + RIGHT_LEAF * leaf[high]
        waiting += [(high, len(out["left"])), (low, -1)]
        out["feature"].append(feature[at] + flags)
        out["threshold"].append(threshold[at])
        out["left"].append(0)


def below(thresholds: np.ndarray) -> np.ndarray:
    """The largest float32 not above each threshold: a float32 lies at most at both, or at none."""
    with np.errstate(over="ignore"):
        near = thresholds.astype(np.float32)
    return np.where(near > thresholds, np.nextafter(near, np.float32(-np.inf)), near)


def number(value: float) -> str:
    """A double as C99 reads it back, bit for bit."""
    return float(value).hex()


def short(value: np.float32 | float) -> str:
    """A float as C reads it back, bit for bit."""
    if np.isinf(value):
        return "INFINITY" if value > 0.0 else "-INFINITY"
    text = format(float(value), ".9g")
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"


def array(kind: str, name: str, items: Iterable[str]) -> str:
    """A constant array, in lines of WIDTH characters."""
    lines, line = [], ""
    for item in items:
        if len(line) + len(item) + 2 > WIDTH:
            lines.append(line.rstrip())
            line = ""
        line += f"{item}, "
    lines.append(line.rstrip(", "))
    return f"static const {kind} {name}[] = {{\n" + "\n".join(lines) + "\n};"
