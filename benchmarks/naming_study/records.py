"""Lines of a study file; those written under former names are read under the present ones."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from benchmarks import study

FORMER = {"told": "assumed_ratio"}  # keys of a line
FORMER_ENDS = {"alike": "same_channels"}  # keys of its `after`
FORMER_KIND = ("scatter told x", "scatter assumed x")  # in the name of its kind


def read(file: Path) -> Iterator[dict[str, Any]]:
    """Whole lines of a file, under present names."""
    for row in study.read(file):
        yield current(row)


def run(
    file: Path,
    cases: Sequence[study.Case],
    measure: Callable[[str, int], dict[str, Any]],
    resume: bool,
    workers: int = 1,
) -> list[dict[str, Any]]:
    """Results of all cases in their order, see `study.run`; known lines are not measured again."""
    known = [row["kind"] for row in study.read(file)] if resume else []
    former = {kind: kind.replace(*FORMER_KIND[::-1]) for kind, _ in cases}
    asked = [(former[kind] if former[kind] in known else kind, seed) for kind, seed in cases]
    rows = study.run(file, asked, Present(measure), resume, workers)
    return [current(row) for row in rows]


class Present:
    """A measurement that is asked for by a former kind's name and measures the present one."""

    def __init__(self, measure: Callable[[str, int], dict[str, Any]]) -> None:
        self.measure = measure

    def __call__(self, kind: str, seed: int) -> dict[str, Any]:
        return self.measure(kind.replace(*FORMER_KIND), seed)


def current(row: dict[str, Any]) -> dict[str, Any]:
    """A line under present names."""
    made = {FORMER.get(key, key): value for key, value in row.items()}
    made["kind"] = made["kind"].replace(*FORMER_KIND)
    if made.get("after"):
        made["after"] = {FORMER_ENDS.get(k, k): value for k, value in made["after"].items()}
    return made
