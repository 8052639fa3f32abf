"""The smallest detectable sizes, as `python -m benchmarks.oracle` froze them."""

import hashlib
import tomllib
from functools import cache
from pathlib import Path

from benchmarks.oracle import FROZEN

ORACLE = {"poor": "poor", "poor, duty": "poor", "rich": "rich"}


@cache
def smallest(protocol: str, file: Path = FROZEN) -> dict[str, float | None]:
    """u by full name (SI); None: beyond the physical range.

    Where duty is logged the poor protocol keeps the sizes it has without: the same cases, told
    more.
    """
    table = tomllib.loads(file.read_text(encoding="utf-8"))[ORACLE[protocol]]
    return {
        name: each["u"] if isinstance(each["u"], float) else None for name, each in table.items()
    }


def digest(file: Path = FROZEN) -> str:
    """Of the frozen file: results of different files never meet."""
    return hashlib.sha256(file.read_bytes()).hexdigest()[:8]
