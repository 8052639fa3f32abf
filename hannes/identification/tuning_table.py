"""Tuning constants with their unit, their meaning and how each was chosen; printed as tables."""

from dataclasses import field, fields
from typing import Any

DEVELOPMENT = "development seeds"  # of benchmarks.naming, none of which is quoted
JUDGEMENT = "judgement"
NUMERICS = "judgement: numerical accuracy"
COST = "judgement: processor time"
CONVENTION = "convention"  # a customary level


def constant(value: Any, unit: str, meaning: str, chosen: str = JUDGEMENT) -> Any:
    """A dataclass field: its value, unit ("1" for none), meaning, and how it was chosen."""
    return field(default=value, metadata={"unit": unit, "meaning": meaning, "chosen": chosen})


def markdown(*tunings: Any) -> str:
    """A Markdown table of every constant of frozen dataclasses made of `constant` fields."""
    rows = ["| constant | value | unit | meaning | chosen by |", "|---|---|---|---|---|"]
    for tuning in tunings:
        for each in fields(tuning):
            value = getattr(tuning, each.name)
            data = each.metadata
            rows.append(
                f"| `{type(tuning).__name__}.{each.name}` | {_text(value)} | {data['unit']} "
                f"| {data['meaning']} | {data['chosen']} |"
            )
    return "\n".join(rows) + "\n"


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        each = (f"({_text(one)})" if isinstance(one, tuple) else _text(one) for one in value)
        return ", ".join(each)
    return f"{value:g}" if isinstance(value, float) else str(value)
