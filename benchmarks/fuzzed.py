"""Damaged files: each is read or refused in one line, and nothing else happens."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from benchmarks.harness import Row, must_show
from hannes.core.errors import BadInput
from hannes.dataset.read import read
from hannes.recognition import model_file
from hannes.recognition.features import CHANNELS, NAMES
from hannes.recognition.hysteresis_features import WHOLE

BYTES = 6  # changed in a file
Use = Callable[[Path], Any]


def queried(path: Path) -> None:
    """Ask a model about windows, and about the peak of a grasp."""
    model = model_file.read(path)
    model.windows(np.zeros((3, len(NAMES))))
    if model.peak:
        model.peak(np.zeros((1, len(WHOLE))))


def trained_on(path: Path) -> None:
    """Read what training reads of a data set."""
    found = read(path)
    list(found.blocks(np.arange(min(18, found.table.size)), (*CHANNELS, "force")))


def damaged(path: Path, use: Use, count: int, seed: int) -> dict[str, int]:
    """How `count` copies with bytes changed at random ended."""
    use(path)  # whole, it is read
    data, rng = path.read_bytes(), np.random.default_rng(seed)
    copy, ends = path.with_suffix(".fuzzed.h5"), {"read": 0, "refused": 0, "otherwise": 0}
    for number in tqdm(range(count), f"damaged {path.name}", leave=False):
        changed = bytearray(data)
        size = len(data) if number % 2 else min(len(data), 6000)  # the head is the index
        for place in rng.integers(0, size, BYTES):
            changed[place] = rng.integers(0, 256)
        copy.write_bytes(changed[: rng.integers(1, size)] if number % 10 == 0 else changed)
        ends[_end(copy, use)] += 1
    copy.unlink()
    return ends


def _end(path: Path, use: Use) -> str:
    try:
        use(path)
    except BadInput as error:
        return "otherwise" if "\n" in str(error) else "refused"
    except Exception:
        return "otherwise"
    return "read"


def measure(quick: bool, model: Path, data: Path) -> tuple[list[Row], list[Row]]:
    """Damage a model and a data set."""
    count = 50 if quick else 500
    ends = {
        "model": damaged(model, queried, count, 1),
        "data set": damaged(data, trained_on, count, 2),
    }
    rows = [{"what": f"{count} damaged copies of a {name}", **each} for name, each in ends.items()]
    wrong = sum(each["otherwise"] for each in ends.values())
    name = f"of {2 * count} damaged files, neither read nor refused in one line"
    return rows, [must_show(name, wrong, 0, wrong == 0)]
