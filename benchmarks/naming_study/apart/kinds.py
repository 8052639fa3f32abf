"""Which cases the study has, and their seeds.

A method is developed on one set of seeds and quoted on another, which is run once. Kinds outside
the catalogue are opened or sealed (see `benchmarks.truth.effects`): development has no sealed one.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from benchmarks.study import Case

SETS = {"development": 400_000_000, "quoted": 410_000_000}  # first seeds
APART = 1_000  # seeds between kinds
QUICK = "quick"


@dataclass(frozen=True)
class Kind:
    """So many cases: what is hidden, and under which protocol.

    counts: by name of a set; quick ones are of the development set. coloured: the current sensor's
    noise has a bandwidth.
    """

    what: str
    protocol: str
    counts: Mapping[str, int]
    coloured: bool = False

    @property
    def name(self) -> str:
        """As tables show it."""
        return f"{self.what}, {self.protocol}{', coloured noise' if self.coloured else ''}"

    @property
    def stated(self) -> bool:
        """Whether the user states scatter and experiments."""
        return self.protocol != "naive"


def _counts(both: int, quick: int = 0) -> dict[str, int]:
    return {"development": both, "quoted": both, QUICK: quick}


KINDS = (
    Kind("single", "naive", _counts(50)),
    Kind("single", "poor", _counts(50, 1)),
    Kind("single", "rich", _counts(50)),
    Kind("sound", "naive", _counts(24)),
    Kind("sound", "poor", _counts(33, 1)),
    Kind("sound", "rich", _counts(33)),
    Kind("sound", "naive", _counts(6), coloured=True),
    Kind("sound", "poor", _counts(12), coloured=True),
    Kind("sound", "rich", _counts(12), coloured=True),
    Kind("pair", "naive", _counts(10)),
    Kind("pair", "poor", _counts(10)),
    Kind("pair", "rich", _counts(10)),
    Kind("triple", "naive", _counts(4)),
    Kind("triple", "poor", _counts(4)),
    Kind("triple", "rich", _counts(4)),
    Kind("fault", "naive", _counts(8)),
    Kind("fault", "poor", _counts(8)),
    Kind("fault", "rich", _counts(8)),
    Kind("opened", "poor", _counts(10)),
    Kind("opened", "rich", _counts(10)),
    Kind("sealed", "poor", {"development": 0, "quoted": 10, QUICK: 0}),
    Kind("sealed", "rich", {"development": 0, "quoted": 10, QUICK: 0}),
    Kind("MuJoCo sound", "poor", _counts(12)),
    Kind("MuJoCo slack", "poor", _counts(6)),
    Kind("MuJoCo load", "poor", _counts(6)),
)
NAMED = {kind.name: kind for kind in KINDS}


def cases(chosen: str, quick: bool = False) -> list[Case]:
    """Name of kind and seed of every case of a set; kinds take turns."""
    counts = {kind.name: kind.counts[QUICK if quick else chosen] for kind in KINDS}
    found = [
        ((k + 0.5) / counts[kind.name], (kind.name, first_seed(kind, chosen) + k))
        for kind in KINDS
        for k in range(counts[kind.name])
    ]
    return [case for _, case in sorted(found, key=lambda each: each[0])]


def first_seed(kind: Kind, chosen: str) -> int:
    """Of a kind's cases in a set."""
    return SETS[chosen] + APART * KINDS.index(kind)


def place(seed: int) -> int:
    """Which case of its kind a seed is, from 0 on."""
    return seed % APART


def is_quoted(seed: int) -> bool:
    """Whether a seed is of the set that is quoted."""
    return seed >= SETS["quoted"]
