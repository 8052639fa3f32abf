"""What `benchmarks.naming` needs of each of its studies."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.harness import Row
from benchmarks.study import Case

Done = list[dict[str, Any]]


@dataclass(frozen=True)
class Study:
    """sets: first seeds by name; kinds: names of its cases; cases: of a set, or its quick ones;
    measured: a line of a kind and seed; named: its file's stem of a set, quick or not; tables: what
    was found, and the rows to print.
    """

    sets: Mapping[str, int]
    kinds: Sequence[str]
    cases: Callable[[str, bool], list[Case]]
    measured: Callable[[str, int], dict[str, Any]]
    named: Callable[[str, bool], str]
    tables: Callable[[Done], tuple[dict[str, Any], Sequence[Sequence[Row]]]]
