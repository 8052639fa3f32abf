"""Definitions of messages that a log brings along: those that make much out of nothing."""

from collections.abc import Mapping
from typing import Any

from hannes.core.errors import BadInput
from hannes.core.io.optional import library

MOST_ELEMENTS = 65_536  # of a list of a fixed length


def require_sized(definitions: Mapping[str, Any], where: str) -> None:
    """Raise BadInput where lists have elements of no bytes: a log of a line could hold billions.

    `definitions`: of the library's types, name to constants and fields.
    """
    kinds = library("rosbags.interfaces", "formats").Nodetype
    empty = _empty(definitions, kinds)
    for name, (_, fields) in definitions.items():
        for _, (kind, what) in fields:
            if kind in (kinds.ARRAY, kinds.SEQUENCE):
                (inner, element), length = what
                nothing = inner == kinds.NAME and element in empty
                if nothing or (kind == kinds.ARRAY and length > MOST_ELEMENTS):
                    raise BadInput(f"{where}: {name:.60} has lists of too many elements")


def _empty(definitions: Mapping[str, Any], kinds: Any) -> set[str]:
    """Types whose messages take no bytes: without fields, or with fields of such types alone."""
    found: set[str] = set()
    while True:
        more = {
            name
            for name, (_, fields) in definitions.items()
            if all(_is_empty(each, found, kinds) for _, each in fields)
        }
        if more <= found:
            return found
        found |= more


def _is_empty(field: Any, empty: set[str], kinds: Any) -> bool:
    kind, what = field
    if kind == kinds.ARRAY:
        return what[1] == 0 or _is_empty(what[0], empty, kinds)
    return kind == kinds.NAME and what in empty
