"""In which form times stand: ISO 8601, or as a pattern of strptime."""

from collections.abc import Sequence
from datetime import datetime

PATTERNS = (
    "%H:%M:%S.%f", "%H:%M:%S", "%d.%m.%Y %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S",
    "%Y/%m/%d %H:%M:%S.%f", "%Y/%m/%d %H:%M:%S", "%d/%m/%Y %H:%M:%S.%f", "%d/%m/%Y %H:%M:%S",
    "%m/%d/%Y %H:%M:%S.%f", "%m/%d/%Y %H:%M:%S",
)  # fmt: skip
LOOKED_AT = 200  # cells


def form_of_stamps(cells: Sequence[str]) -> str:
    """The one form that all cells have, "" where none or more than one fits."""
    known = [cell for cell in cells if cell][:LOOKED_AT]
    if all(_is_iso(cell) for cell in known):
        return "iso"
    fitting = [form for form in PATTERNS if all(_fits(cell, form) for cell in known)]
    return fitting[0] if len(fitting) == 1 else ""


def _is_iso(cell: str) -> bool:
    try:
        datetime.fromisoformat(cell)
    except ValueError:
        return False
    return True


def _fits(cell: str, form: str) -> bool:
    try:
        datetime.strptime(cell, form)
    except ValueError:
        return False
    return True
