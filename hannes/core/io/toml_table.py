"""Tables of a TOML file, read strictly: every error names the file, the key and what is allowed."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from hannes.core.errors import BadInput, nearest
from hannes.core.io.bounded import read_bytes
from hannes.core.io.limits import MIB, TOML_BYTES, TOML_PARTS
from hannes.core.io.units import quantity

WHAT = "a TOML file"
# A dotted key of so many parts, outside texts: tomllib takes their square in time.
_LONG_KEY = re.compile(rf"(?:\.[^.,\n=]{{1,80}}){{{TOML_PARTS}}}")
_PART, _LIST, _TABLE = 170, 72, 800  # bytes that a key, a list, a [table] takes besides its text


def read_text(path: Path) -> str:
    """Return the text of a TOML file; BadInput where it cannot be read."""
    try:
        return read_bytes(path, WHAT, TOML_BYTES).decode("utf-8").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise BadInput(f"{path}: is not UTF-8 text; expected a TOML file") from None


def parsed(text: str) -> dict[str, Any]:
    """Return the content of a TOML text.

    Raises ValueError where it is none, RecursionError where it is nested too deep.
    """
    if len(text) > TOML_BYTES:
        raise ValueError(f"longer than {TOML_BYTES} characters")
    if _LONG_KEY.search(text):
        raise ValueError(f"a key of more than {TOML_PARTS} parts")
    taken = _PART * text.count("=") + _LIST * text.count("[") + _TABLE * text.count("\n[")
    if taken > 12 * len(text) + 64 * MIB:
        raise ValueError("too many keys")
    return tomllib.loads(text)


@dataclass(frozen=True)
class Table:
    """One table: `where` names the file, `prefix` the table ("object."), `allowed` its keys."""

    content: Mapping[str, Any]
    where: str
    allowed: tuple[str, ...]
    prefix: str = ""

    @classmethod
    def parse(cls, text: str, where: str, allowed: tuple[str, ...]) -> "Table":
        """Return the root table of a TOML text; BadInput for a syntax error or unknown key."""
        try:
            content = parsed(text)
        except RecursionError:
            raise BadInput(f"{where}: is not valid TOML: nested too deep") from None
        except ValueError as error:
            reason = " ".join(str(error).split())
            raise BadInput(f"{where}: is not valid TOML: {reason:.300}") from None
        return cls(content, where, allowed)

    def __post_init__(self) -> None:
        for key in self.content:
            if self.allowed and key not in self.allowed:
                raise BadInput(
                    f'{self.where}: unknown key "{self.prefix}{key[:60]}"'
                    f"{nearest(key, self.allowed)} (allowed: {', '.join(self.allowed)})"
                )

    def __contains__(self, key: str) -> bool:
        return key in self.content

    def name(self, key: str) -> str:
        """File and full key, as messages show them."""
        return f"{self.where}: {self.prefix}{key}"

    def refuse(self, key: str, why: str) -> NoReturn:
        """Raise BadInput about one key."""
        raise BadInput(f"{self.name(key)} {why}")

    def require(self, key: str, example: str) -> Any:
        """Return the raw value of a key that must be there."""
        if key not in self.content:
            self.refuse(key, f"is missing: expected a line such as {key} = {example}")
        return self.content[key]

    def quantity(self, key: str, unit: str, example: str = "") -> float:
        """Return the SI value of a key that must be there."""
        return quantity(self.require(key, f'"{example}"'), unit, self.name(key))

    def text(self, key: str, default: str) -> str:
        """Return a text of one line."""
        value = self.content.get(key, default)
        if not isinstance(value, str) or not value.isprintable():
            self.refuse(key, "must be text on one line, in quotes")
        return value

    def choice(self, key: str, choices: tuple[str, ...], default: str = "") -> str:
        """Return one of `choices`; without a default the key must be there."""
        value = self.content.get(key, default) if default else self.require(key, f'"{choices[0]}"')
        if not isinstance(value, str) or value not in choices:
            hint = nearest(value, choices) if isinstance(value, str) else ""
            shown = f'"{value[:60]}"' if isinstance(value, str) else f"a {type(value).__name__}"
            self.refuse(key, f"= {shown}: expected one of {', '.join(choices)}{hint}")
        return value

    def flag(self, key: str) -> bool:
        """Return true or false; false where the key is absent."""
        value = self.content.get(key, False)
        if not isinstance(value, bool):
            self.refuse(key, "must be true or false, without quotes")
        return value

    def whole(self, key: str, low: int, high: int, default: int | None = None) -> int:
        """Return a whole number between `low` and `high`, both included."""
        value = self.require(key, str(low)) if default is None else self.content.get(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            self.refuse(key, f"must be a whole number from {low} to {high}, without quotes")
        return value

    def items(self, key: str, length: int | None = None) -> list[Any]:
        """Return a list, of `length` items where that is given; empty where the key is absent."""
        value = self.content.get(key, [])
        if not isinstance(value, list) or (length is not None and len(value) != length):
            self.refuse(
                key, f"must be a list{f' of {length} values' if length else ''} in brackets"
            )
        return value

    def texts(self, key: str) -> list[str]:
        """Return a list of texts; empty where the key is absent."""
        values = self.items(key)
        if not all(isinstance(each, str) and each.isprintable() for each in values):
            self.refuse(key, "must be a list of texts of one line, each in quotes")
        return values

    def table(self, key: str, allowed: tuple[str, ...] = ()) -> "Table":
        """Return a table below this one, empty where absent; no `allowed` lets any key pass."""
        value = self.content.get(key, {})
        if not isinstance(value, dict):
            self.refuse(key, f"must be a table: a line [{self.prefix}{key}], its keys below")
        return Table(value, self.where, allowed, f"{self.prefix}{key}.")
