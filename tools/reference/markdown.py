"""Tables and headings in Markdown."""

from collections.abc import Iterable, Sequence


def table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table; a bar inside a cell is escaped."""
    lines = [f"| {' | '.join(columns)} |", f"|{'---|' * len(columns)}"]
    lines += [f"| {' | '.join(_cell(each) for each in row)} |" for row in rows]
    return "\n".join(lines)


def _cell(content: object) -> str:
    return " ".join(str(content).split()).replace("|", "\\|")


def code(text: object) -> str:
    """As code."""
    return f"`{text}`"


def number(value: float) -> str:
    """Six digits at most, as `hannes hand` shows it."""
    return f"{value:.6g}"
