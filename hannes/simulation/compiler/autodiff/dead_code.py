"""Lines of generated text that something needs."""

import re
from collections.abc import Sequence


def without_dead_code(lines: Sequence[str]) -> list[str]:
    """Drop the lines that compute what nothing needs."""
    needed: set[str] = set()
    kept: list[str] = []
    for line in reversed(lines):
        target = re.match(r"\s*(v\w+(?:, v\w+)*) = ", line)
        if target and not needed & set(target[1].split(", ")):
            continue
        if line.endswith(":") and (not kept or _depth(kept[-1]) <= _depth(line)):
            if line.strip() == "else:" or not kept or kept[-1].strip() != "else:":
                continue
            kept.append(" " * (_depth(line) + 4) + "pass")
        needed |= set(re.findall(r"\bv\d\w*", line[target.end() :] if target else line))
        kept.append(line)
    return kept[::-1]


def _depth(line: str) -> int:
    return len(line) - len(line.lstrip())
