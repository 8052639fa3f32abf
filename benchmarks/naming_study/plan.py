"""Which cases the study has, and their seeds.

Seeds of cases that a method was developed on and of cases that are quoted differ: SETS. Those from
20, 30 and so on to 160 million on were quoted once, most in part, and looked at when the method was
changed after it.
Cases with a wrong assumed scatter are those of the first kinds again, by their seeds.
"""

from dataclasses import dataclass

from benchmarks.study import Case

SETS = {"development": 10_000_000, "quoted": 170_000_000}  # first seeds
APART = 10_000  # seeds between kinds


@dataclass(frozen=True)
class Kind:
    """So many cases: what is hidden, under which protocol, and how wrong the assumed scatter is.

    assumed_ratio: assumed over true scatter. counts: whole, quick.
    """

    what: str
    protocol: str
    counts: tuple[int, int]
    assumed_ratio: float = 1.0

    @property
    def name(self) -> str:
        """As tables show it."""
        scatter = "" if self.assumed_ratio == 1.0 else f", scatter assumed x{self.assumed_ratio:g}"
        return f"{self.what}, {self.protocol}{scatter}"


KINDS = (  # a first look has no rich case with anything hidden: those take minutes
    Kind("closures", "closures", (12, 1)),
    Kind("single", "poor", (60, 1)),
    Kind("single", "poor, duty", (40, 1)),
    Kind("single", "rich", (50, 0)),
    Kind("empty", "poor", (170, 0)),
    Kind("empty", "rich", (30, 1)),
    Kind("outside", "poor", (25, 1)),
    Kind("outside", "rich", (15, 0)),
    Kind("pair", "poor", (12, 1)),
    Kind("pair", "rich", (15, 0)),
    Kind("single", "poor", (15, 0), assumed_ratio=0.5),
    Kind("single", "poor", (15, 0), assumed_ratio=2.0),
    Kind("empty", "poor", (15, 0), assumed_ratio=0.5),
    Kind("empty", "poor", (15, 0), assumed_ratio=2.0),
)
NAMED = {kind.name: kind for kind in KINDS}
# The poor protocol's cases are the same with and without duty.
_ORIGINS = list(dict.fromkeys((k.what, k.protocol.partition(",")[0]) for k in KINDS))


def cases(chosen: str, quick: bool) -> list[Case]:
    """Name of kind and seed of every case of a set; kinds take turns."""
    found = [
        ((k + 0.5) / kind.counts[quick], (kind.name, first_seed(kind, chosen) + k))
        for kind in KINDS
        for k in range(kind.counts[quick])
    ]
    return [case for _, case in sorted(found, key=lambda each: each[0])]


def first_seed(kind: Kind, chosen: str) -> int:
    """Of a kind's cases in a set."""
    origin = (kind.what, kind.protocol.partition(",")[0])
    return SETS[chosen] + APART * _ORIGINS.index(origin)
