"""The study as `benchmarks.naming` runs it."""

from collections.abc import Sequence
from typing import Any

from benchmarks.harness import Row
from benchmarks.naming_study import frozen
from benchmarks.naming_study.apart import summary
from benchmarks.naming_study.apart.kinds import NAMED, SETS, cases
from benchmarks.naming_study.apart.work import measured
from benchmarks.naming_study.choice import Study
from benchmarks.oracle import APART


def named(chosen: str, quick: bool) -> str:
    """Of the file: one for each set of seeds and frozen file of sizes."""
    return f"naming-apart-{chosen}{'-quick' if quick else ''}-{frozen.digest(APART)}"


def tables(done: list[dict[str, Any]]) -> tuple[dict[str, Any], Sequence[Sequence[Row]]]:
    """What was found, and its tables."""
    rows, bounds = summary.figures(done)
    open_cases = summary.missing(done)
    return {"rows": rows, "must_show": bounds}, (rows, open_cases, bounds)


STUDY = Study(SETS, tuple(NAMED), cases, measured, named, tables)
