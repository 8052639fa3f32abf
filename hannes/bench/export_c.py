"""`hannes export-c`: a trained model as one C file without allocation, for a board's firmware.

What moves is the recognition that `hannes live` does: features, trees, calibration, decision,
stiffness (by networks too, where the model has them), the most force so far; and the grip policy
that goes by them. The peak force after release, which a Gaussian process over thousands of grasps
predicts, stays with the host.
"""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from hannes.bench.c_networks import network_sizes, networks
from hannes.bench.c_tables import CForest, array, c_forest, is_single, number
from hannes.bench.c_vectors import SAMPLES, vectors
from hannes.bench.live import LONGEST, NORMAL_95
from hannes.bench.policy import GripSettings
from hannes.bench.release import RETREAT, TURN
from hannes.core.errors import BadInput
from hannes.dataset import touch_seen
from hannes.recognition import features
from hannes.recognition.model import EXTREME, FADE, HELD, LATER, NO_CONTACT, Band, Model

PARTS = Path(__file__).parent / "firmware" / "parts"
FLAGS = "-std=c99 -O2 -ffp-contract=off"
GRIP = 8 * 13  # bytes of a struct HannesGrip: its flags fill the place of a double
FORESTS = ("rigid", "stiffness", "force")
GRIP_NAMES = {"speed": "GRIP_SPEED"}  # of its settings, where they are not their own in capitals
HEAD = """\
/* Rigid or soft, stiffness and grip force from motor current, position and reference; grip policy.
 * Written by `hannes export-c`; do not edit it, export the model anew.
 *
 * Model:   {trained}
 * Memory:  {memory} bytes in one struct Hannes, one struct HannesGrip and, where the model knows
 *          hands, one struct HannesEmpty, all there is; nothing is allocated.
 * Tables:  {tables} bytes of constants in {trees} trees of {nodes} nodes.
 * Rate:    hannes_sample() once a sample, at {sampling:g} Hz; a decision every {hop:g} ms.
 * Build:   cc {flags} -c FILE.c      (C99 and <math.h>; no -ffast-math)
 * Check:   cc {flags} -DHANNES_SELF_TEST FILE.c -lm && ./a.out
 *
 * Features, votes and calibrated probabilities have the bits of Python's on any machine with IEEE
 * doubles; exp and log are the C library's, and may differ from numpy's in the last bit.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
"""


@dataclass(frozen=True)
class Exported:
    """A model in C: its text, bytes of memory and of constant tables, trees and nodes."""

    text: str
    memory_bytes: int
    table_bytes: int
    trees: int
    nodes: int


def export_c(model: Model) -> Exported:
    """Return `model` as one C file. Raises BadInput where its windows fit no whole samples."""
    sizes = _sizes(model)
    leaf = "float" if all(is_single(getattr(model, name)) for name in FORESTS) else "double"
    forests = {name: c_forest(name, getattr(model, name), leaf) for name in FORESTS}
    memory = _memory(sizes)
    nets = networks(model.pressed, model.windowing.sampling)
    tables = nets.table_bytes + sum(each.table_bytes for each in forests.values())
    trees, nodes = (sum(getattr(f, k) for f in forests.values()) for k in ("trees", "nodes"))
    head = HEAD.format(
        trained=_comment(model.trained), memory=memory, tables=tables, trees=trees, nodes=nodes,
        sampling=model.windowing.sampling, hop=1e3 * model.windowing.hop, flags=FLAGS,
    )  # fmt: skip
    parts = [
        head,
        _defined(sizes | {"MEMORY_BYTES": f"{memory}u"} | _constants(model)),
        _tables(model, forests.values(), leaf),
        nets.text,
        (PARTS / "recogniser.c").read_text(encoding="utf-8"),
        vectors(model),
        (PARTS / "self_test.c").read_text(encoding="utf-8"),
    ]
    return Exported("\n".join(parts), memory, tables, trees, nodes)


def _sizes(model: Model) -> dict[str, str]:
    """Whole numbers of the file, in samples unless their names say otherwise."""
    windowing = model.windowing
    period = 1.0 / windowing.sampling
    if (hop := round(windowing.hop * windowing.sampling)) < 1:
        raise BadInput(f"a hop of {windowing.hop:g} s is less than a sample")
    smooth, memory = max(1, round(touch_seen.SMOOTH / period)), round(touch_seen.MEMORY / period)
    reach = max(2 * windowing.size, memory + windowing.size, smooth) + 1
    longest = int(LONGEST * windowing.sampling + 1e-6)
    held = min(longest // hop // 2 + 1, LATER)
    trees = max(getattr(model, name).starts.size - 1 for name in FORESTS)
    return {
        "WINDOW": f"{windowing.size}",
        "HOP": f"{hop}",
        "SMOOTH": f"{smooth}",
        "MEMORY": f"{memory}",
        "STARTING": f"{round(touch_seen.STARTING / period)}",
        "KEPT": f"{1 << (reach - 1).bit_length()}u",
        "LONGEST": f"{longest}u",
        "HELD": f"{held}u",
        "SCRATCH": f"{max(held, trees)}u",
        "RATE": f"{round(windowing.sampling)}u",
        "FEATURES": f"{len(features.NAMES)}",
        "LEVELS": f"{len(features.LEVELS)}",
        "CALIBRATION": f"{model.calibration.x.size}u",
        "VECTOR_SAMPLES": f"{SAMPLES}u",
        **network_sizes(model.pressed, windowing.sampling),
    }


def _constants(model: Model) -> dict[str, str]:
    """Numbers of the file, in SI units."""
    values = {
        "PERIOD": 1.0 / model.windowing.sampling,
        "MOVED": touch_seen.MOVED,
        "STEP": touch_seen.STEP,
        "BACK": touch_seen.BACK,
        "HOLD": HELD,
        "NO_CONTACT": NO_CONTACT,
        "EXTREME": EXTREME,
        "SHARE": min(1.0, model.windowing.hop / FADE),
        "SURE": model.sure,
        "BORDER": model.border,
    }
    if model.pressed:
        values["REACH"] = float(model.pressed.reach[0])
        errors = NORMAL_95 * model.pressed.error
        values |= dict(zip(("ERROR", "ERROR_KNOWN"), map(float, errors), strict=True))
    values |= {GRIP_NAMES.get(key, key.upper()): x for key, x in asdict(GripSettings()).items()}
    values |= {"RETREAT": RETREAT, "TURN": TURN}
    return {name: f"({number(value)})" for name, value in values.items()}


def _memory(sizes: dict[str, str]) -> int:
    """Bytes of all structs where doubles stand at multiples of eight."""
    kept, held, scratch, levels, count, bins = (
        int(sizes[name].rstrip("u"))
        for name in ("KEPT", "HELD", "SCRATCH", "LEVELS", "FEATURES", "BINS")
    )
    doubles = 2 + 4 * kept + 8 + levels + 1 + 2 * held + scratch + 1 + 3 + 3 * bins
    rows = 4 * (count + count % 2)
    hands = int(sizes["HAND"])
    empty = 8 + 8 * (2 + int(sizes["NUMBERS"]) + hands) if hands else 0
    return 16 + 8 * doubles + 8 + 8 + rows + GRIP + empty


def _defined(values: dict[str, str]) -> str:
    return "\n".join(f"#define HANNES_{name} {value}" for name, value in values.items()) + "\n"


def _tables(model: Model, forests: Iterable[CForest], leaf: str) -> str:
    curve = model.calibration
    lines = [
        "struct HannesForest {",
        "    uint32_t trees;",
        "    const uint32_t *start; /* first inner node of each tree, and the end */",
        "    const uint8_t *feature; /* + 128: its left child is a leaf, + 64: its right one is */",
        "    const float *threshold;",
        "    const uint16_t *left; /* inner nodes under the left child; see also far */",
        "    const uint32_t *far; /* the same where 16 bits are too few, else NULL */",
        "    const uint16_t *place; /* of a leaf among the values, NULL where each has its own */",
        f"    const {leaf} *value;",
        "};",
        "struct HannesBand { uint32_t count; const double *x, *low, *high; };",
        array("double", "hannes_levels", map(number, features.LEVELS)),
        array("double", "hannes_calibration_x", map(number, curve.x)),
        array("double", "hannes_calibration_y", map(number, curve.y)),
        *(
            _band(f"hannes_{name}", getattr(model, name))
            for name in ("stiffness_band", "force_band")
        ),
        *(each.text for each in forests),
    ]
    return "\n".join(lines) + "\n"


def _band(name: str, band: Band) -> str:
    columns: dict[str, Sequence[float] | np.ndarray] = {
        "x": band.x, "low": band.low, "high": band.high
    }  # fmt: skip
    arrays = [array("double", f"{name}_{key}", map(number, each)) for key, each in columns.items()]
    names = ", ".join(f"{name}_{key}" for key in columns)
    arrays.append(f"static const struct HannesBand {name} = {{{band.x.size}u, {names}}};")
    return "\n".join(arrays)


def _comment(text: str) -> str:
    """A text that cannot end a comment."""
    return " ".join(text.replace("*/", "* /").split()) or "without a description"
