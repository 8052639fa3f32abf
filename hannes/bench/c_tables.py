"""Arrays and trees as C constants that give back the same bits."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from hannes.recognition.forest import Forest

LEAF = 255  # in place of a leaf's feature
WIDTH = 100


@dataclass(frozen=True)
class CForest:
    """A forest as C constants: their text, their bytes, how many trees and nodes."""

    text: str
    table_bytes: int
    trees: int
    nodes: int


def c_forest(name: str, forest: Forest) -> CForest:
    """Trees of `forest` as a `struct HannesForest hannes_<name>`, left children next to parents."""
    order, right = preorder(forest)
    inner = forest.left[order] >= 0
    values, place = np.unique(forest.value[order][~inner], return_inverse=True)
    following = right.copy()
    following[~inner] = place
    feature = np.where(inner, forest.feature[order], LEAF)
    threshold = np.where(inner, below(forest.threshold[order]), np.float32(0.0))
    own = f"hannes_{name}"
    parts = {
        "start": array("uint32_t", f"{own}_start", map(str, forest.starts[:-1])),
        "next": array("uint32_t", f"{own}_next", map(str, following)),
        "feature": array("uint8_t", f"{own}_feature", map(str, feature)),
        "threshold": array("float", f"{own}_threshold", map(short, threshold)),
        "value": array("double", f"{own}_value", map(number, values)),
    }
    trees, nodes = forest.starts.size - 1, order.size
    names = ", ".join(f"{own}_{part}" for part in parts)
    text = "\n".join(
        [*parts.values(), f"static const struct HannesForest {own} = {{{trees}u, {names}}};"]
    )
    return CForest(text, 4 * trees + 9 * nodes + 8 * values.size, trees, nodes)


def preorder(forest: Forest) -> tuple[np.ndarray, np.ndarray]:
    """Nodes in the order in which a left child follows its parent; place of each right child."""
    nodes = forest.left.size
    order, right = np.arange(nodes), np.zeros(nodes, np.int64)
    for start, end in zip(forest.starts[:-1], forest.starts[1:], strict=True):
        waiting, at = [(int(start), -1)], int(start)
        while waiting:
            node, parent = waiting.pop()
            order[at] = node
            if parent >= 0:
                right[parent] = at
            if forest.left[node] >= 0:
                waiting.append((int(start + forest.right[node]), at))
                waiting.append((int(start + forest.left[node]), -1))
            at += 1
        if at != end:
            order[at:end], right[at:end] = start, 0  # nodes that no path reaches
    return order, right


def below(thresholds: np.ndarray) -> np.ndarray:
    """The largest float32 not above each threshold: a float32 lies at most at both, or at none."""
    with np.errstate(over="ignore"):
        near = thresholds.astype(np.float32)
    return np.where(near > thresholds, np.nextafter(near, np.float32(-np.inf)), near)


def number(value: float) -> str:
    """A double as C99 reads it back, bit for bit."""
    return float(value).hex()


def short(value: np.float32) -> str:
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
