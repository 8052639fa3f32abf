"""Columns of JSON: a list of records, a table of lists, or one record a line (JSON lines)."""

import itertools
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hannes.campaigns.foreign.binary_columns import Arrays, require_file
from hannes.campaigns.foreign.nested import DEEPEST, columns
from hannes.core.errors import BadInput
from hannes.core.io.bounded import read_bytes
from hannes.core.io.json_text import parsed
from hannes.core.io.limits import MIB

SPACE = " \t\r\n"
FEWEST = 20  # samples of a run
_OBJECT, _LIST, _ITEM = 192, 64, 40  # bytes that each takes besides its text


def open_json(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read a JSON file or JSON lines; BadInput with the line that cannot be read."""
    text = _text(path)
    try:
        found = _whole(text, path)
    except ValueError as error:
        found = _listed(_lines(path, text, error), path, len(text))
    if not found:
        raise BadInput(f"{path}: no numbers in it; expected a list of records, or lists by name")
    return Arrays(path, found, found.__getitem__, missing)


def _text(path: Path) -> str:
    require_file(path)
    try:
        return read_bytes(path, "JSON").decode("utf-8-sig")
    except UnicodeDecodeError:
        raise BadInput(f"{path}: not UTF-8 text; JSON is always UTF-8") from None


def _whole(text: str, path: Path) -> dict[str, Any]:
    """Columns of one JSON value; ValueError where the text is none."""
    start = len(text) - len(text.lstrip(SPACE))
    if text.startswith("[", start):
        return _listed(_items(text, start + 1, path), path, len(text))
    _refuse_lines(text)
    taken = _OBJECT * text.count("{") + _LIST * text.count("[") + _ITEM * text.count(",")
    if taken > 12 * len(text) + 64 * MIB:
        raise BadInput(f"{path}: too many small parts; write one record a line (JSON lines)")
    return _columns(_decoded(json.JSONDecoder().decode, text, path), path, len(text))


def _refuse_lines(text: str) -> None:
    """Raise ValueError where the first line is a record of its own, and more follow."""
    first, _, rest = text.partition("\n")
    if rest.strip(SPACE):
        try:
            parsed(first)
        except ValueError:
            return
        raise ValueError("one record a line")


def _decoded(decode: Any, text: Any, path: Path) -> Any:
    try:
        return decode(text)
    except RecursionError:
        raise BadInput(f"{path}: nested too deep; this is no log of samples") from None


def _items(text: str, place: int, path: Path) -> Iterator[Any]:
    """Items of a list one by one: only one is in memory as Python's own objects."""
    decoder, place = json.JSONDecoder(), _after_space(text, place)
    while not text.startswith("]", place):
        item, place = _decoded(lambda at: decoder.raw_decode(text, at), place, path)
        yield item
        place = _after_space(text, place)
        if text.startswith(",", place):
            place = _after_space(text, place + 1)
            if text.startswith("]", place):
                raise json.JSONDecodeError("Expecting value", text, place)
        elif not text.startswith("]", place):
            raise json.JSONDecodeError("Expecting ',' delimiter", text, place)
    if text[place + 1 :].strip(SPACE):
        raise json.JSONDecodeError("Extra data", text, place + 1)


def _after_space(text: str, place: int) -> int:
    while text[place : place + 1] in SPACE and place < len(text):
        place += 1
    return place


def _lines(path: Path, text: str, whole: ValueError) -> Iterator[Any]:
    """One record a line; a last line that was cut off is left out."""
    number, count, start, last = 0, 0, 0, len(text.rstrip())
    while start < last:
        end = text.find("\n", start)
        end = len(text) if end < 0 else end
        number, line, start = number + 1, text[start:end], end + 1
        if not line.strip():
            continue
        try:
            record = parsed(line)
        except ValueError as error:
            if start > last and count > 1:
                return
            reason = whole if count < 2 else error
            raise BadInput(f"{path}, line {number}: is no JSON ({reason})") from None
        count += 1
        yield record


def _columns(content: Any, path: Path, decoded: int, depth: int = 0) -> dict[str, Any]:
    """Columns by path: of a list of records, or of a table of equally long lists."""
    if isinstance(content, list):
        return _listed(content, path, decoded, depth)
    if not isinstance(content, dict) or depth > DEEPEST:
        return {}
    found: dict[str, Any] = {}
    for name, value in content.items():
        inside = _columns(value, path, decoded, depth + 1) if value else {}
        found |= {f"{name}/{key}" if key else name: each for key, each in inside.items()}
    return {name: np.asarray(each) for name, each in found.items()}


def _listed(items: Iterable[Any], path: Path, decoded: int, depth: int = 0) -> dict[str, Any]:
    """Columns of a list of records, or by number of a list of runs, each of equally long lists.

    Runs are fewer than their samples, records are not.
    """
    source = iter(items)
    first = next(source, None)
    size = _samples(first)
    begun = [] if first is None else [first, *itertools.islice(source, size)]
    if not size or len(begun) > size or not all(map(_samples, begun)) or depth > DEEPEST:
        return columns(itertools.chain(begun, source), str(path), decoded)
    found: dict[str, Any] = {}
    for number, run in enumerate(begun, start=1):
        inside = _columns(run, path, decoded, depth + 1)
        found |= {f"{number}/{name}": each for name, each in inside.items()}
    return found


def _samples(item: Any, depth: int = 0) -> int:
    """How many samples a run has: lists of numbers or of records; 0 for what is no run."""
    if isinstance(item, list):
        return len(item) if len(item) >= FEWEST and all(isinstance(x, dict) for x in item) else 0
    if not isinstance(item, dict) or depth > DEEPEST:
        return 0
    sizes = [_samples(each, depth + 1) if isinstance(each, dict) else len(each)
             for each in item.values() if isinstance(each, dict | list)]  # fmt: skip
    alike = bool(sizes) and min(sizes) == max(sizes) >= FEWEST
    return sizes[0] if alike and _lists(item) > 1 else 0


def _lists(item: Any, depth: int = 0) -> int:
    """How many lists there are in a run, as deep as columns are looked for."""
    if isinstance(item, dict) and depth <= DEEPEST:
        return sum(_lists(each, depth + 1) for each in item.values())
    return int(isinstance(item, list))
