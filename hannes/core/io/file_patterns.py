"""Files that match a pattern in a campaign or an evaluation, in the order of their numbers."""

import re
from pathlib import Path

from hannes.core.errors import BadInput

_SIGNS = "*?["


def is_pattern(name: str) -> bool:
    """Return whether a name is a pattern, which any number of files may match."""
    return any(sign in name for sign in _SIGNS)


def matching(pattern: str, folder: Path) -> list[Path]:
    """Files that match a pattern, relative to `folder` or absolute: void_2.csv before void_10.csv.

    Raises BadInput where the pattern is not valid.
    """
    root = Path(pattern).anchor
    inside = pattern.removeprefix(root)
    if not Path(inside).parts or any("**" in part and part != "**" for part in Path(inside).parts):
        raise BadInput(f'"{pattern}" is no pattern of files: expected a name, ** alone between /')
    try:
        return sorted(Path(root or folder).glob(inside), key=_counted)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise BadInput(f'"{pattern[:60]}" is no pattern of files: {reason}') from None


def _counted(path: Path) -> tuple[list[str | int], str]:
    """A sort key by the numbers within names; 02 comes after 2."""
    name = str(path)
    return [int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", name)], name
