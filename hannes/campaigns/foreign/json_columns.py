"""Columns of JSON: a list of records, a table of lists, or one record a line (JSON lines)."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from hannes.campaigns.foreign.binary_columns import Arrays
from hannes.campaigns.foreign.nested import columns
from hannes.core.errors import BadInput
from hannes.core.recording.csv import read_bytes


def open_json(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read a JSON file or JSON lines; BadInput with the line that cannot be read."""
    text = _text(path)
    try:
        content = json.loads(text)
    except RecursionError:
        raise BadInput(f"{path}: nested too deep; this is no log of samples") from None
    except ValueError as error:
        content = _lines(path, text, error)
    found = _columns(content, path)
    if not found:
        raise BadInput(f"{path}: no numbers in it; expected a list of records, or lists by name")
    return Arrays(path, found, found.__getitem__, missing)


def _text(path: Path) -> str:
    try:
        return read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise BadInput(f"{path}: not UTF-8 text; JSON is always UTF-8") from None


def _lines(path: Path, text: str, whole: ValueError) -> list[Any]:
    """One record a line; a last line that was cut off is left out."""
    lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
    records = []
    for place, (number, line) in enumerate(lines):
        try:
            records.append(json.loads(line))
        except (ValueError, RecursionError) as error:
            if place == len(lines) - 1 and len(records) > 1:
                break
            reason = whole if len(records) < 2 else error
            raise BadInput(f"{path}, line {number}: is no JSON ({reason})") from None
    return records


def _columns(content: Any, path: Path) -> dict[str, Any]:
    """Columns by path: of a list of records, or of a table of equally long lists."""
    if isinstance(content, list):
        return columns(content, str(path))
    if not isinstance(content, dict):
        return {}
    found: dict[str, Any] = {}
    for name, value in content.items():
        if isinstance(value, list) and value:
            inside = columns(value, str(path))
            found |= {f"{name}/{key}" if key else name: each for key, each in inside.items()}
        elif isinstance(value, dict):
            inside = _columns(value, path)
            found |= {f"{name}/{key}": each for key, each in inside.items()}
    return {name: np.asarray(each) for name, each in found.items()}
