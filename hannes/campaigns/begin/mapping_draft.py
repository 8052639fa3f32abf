"""A mapping while it is written: its lines, and what has to be filled in."""

from collections.abc import Sequence
from dataclasses import dataclass, field

FILL_IN = "?"  # where only a person knows


@dataclass
class Draft:
    """Lines of a mapping, what was seen, and what is to be filled in."""

    lines: list[str] = field(default_factory=list)
    seen: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The mapping's TOML."""
        return "\n".join(self.lines) + "\n"

    def ask(self, what: str) -> None:
        """Note what only a person knows."""
        self.missing.append(what)

    def insert(self, after: str, line: str) -> None:
        """Write a line below another one."""
        self.lines.insert(self.lines.index(after) + 1, line)

    def stack(self, plant: str, arrays: Sequence[str]) -> None:
        """Make each row of arrays (runs, n) a run."""
        self.insert(f'plant = "{plant}"', 'split_at = "stacked"  # each row of an array is a run')
        self.seen.append(f"each row of {', '.join(arrays)} as a run")
