"""Long studies: one line of JSON for each case, so that what was done is never done twice."""

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

Case = tuple[str, int]  # kind and seed


def run(
    file: Path, cases: Sequence[Case], measure: Callable[[str, int], dict[str, Any]], resume: bool
) -> list[dict[str, Any]]:
    """Results of all cases in their order; lines already in `file` are kept where `resume`."""
    file.parent.mkdir(parents=True, exist_ok=True)
    if not resume:
        file.unlink(missing_ok=True)
    done = {(row["kind"], row["seed"]): row for row in read(file)}
    for kind, seed in tqdm([case for case in cases if case not in done], "cases"):
        row = {"kind": kind, "seed": seed, **measure(kind, seed)}
        with file.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(row) + "\n")
        done[(kind, seed)] = row
    return [done[case] for case in cases]


def read(file: Path) -> Iterable[dict[str, Any]]:
    """Whole lines of a file; what a killed study left of its last one is passed over."""
    if not file.exists():
        return
    text = file.read_text(encoding="utf-8")
    if not text.endswith("\n") and text:
        file.write_text(text[: text.rfind("\n") + 1], encoding="utf-8")
    for line in text.splitlines(keepends=True):
        if line.endswith("\n"):
            yield json.loads(line)
