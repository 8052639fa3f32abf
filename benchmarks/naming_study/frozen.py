"""The smallest detectable sizes, as `python -m benchmarks.oracle` froze them."""

import hashlib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from benchmarks.oracle import APART, FOLDER, FROZEN

ORACLE = {"poor": "poor", "poor, duty": "poor", "rich": "rich", "naive": "poor"}


@dataclass(frozen=True)
class Smallest:
    """u: smallest detectable size (SI), None beyond the physical range; shape: by full name."""

    u: float | None
    shape: Mapping[str, float]


@cache
def smallest(protocol: str, file: Path = FROZEN) -> dict[str, list[Smallest]]:
    """By full name of an amplitude, one for each shape that its effect was asked about in.

    Where duty is logged the poor protocol keeps the sizes it has without: the same cases
    with more channels.
    """
    table = tomllib.loads(file.read_text(encoding="utf-8"))[ORACLE[protocol]]
    return {
        name: [
            Smallest(each["u"] if isinstance(each["u"], float) else None, each.get("shape", {}))
            for each in entries
        ]
        for name, entries in table.items()
    }


def measured(effect: str) -> Path | None:
    """The file that has the sizes of an effect, None where they are not yet measured."""
    own = FOLDER / f"{effect}.toml"
    if own.exists():
        return own
    for file in (FROZEN, APART):
        if effect in {name.partition(".")[0] for name in smallest("poor", file)}:
            return file
    return None


def digest(file: Path = FROZEN) -> str:
    """Of the frozen file: results of different files never meet."""
    return hashlib.sha256(file.read_bytes()).hexdigest()[:8]
