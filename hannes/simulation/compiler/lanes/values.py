"""What text for lanes computes with: numbers of one lane or of all, arrays, records."""

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from llvmlite import ir

REAL, WHOLE, TRUTH = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
POINTER = ir.PointerType()
TYPES = {"real": REAL, "whole": WHOLE, "truth": TRUTH, "byte": ir.IntType(8), "place": POINTER}
RANKS = ("truth", "whole", "real", "place")


class NotInLanes(Exception):
    """The text has something that is not compiled for lanes."""


@dataclass(frozen=True)
class Number:
    """A number: its kind, whether it differs from lane to lane, itself where known."""

    ir: ir.Value
    kind: str
    varying: bool = False
    known: float | None = None
    over: ir.Value | None = None  # where its reciprocal lies, if that is known


@dataclass(frozen=True)
class Array:
    """An array at an address: shape and strides in elements.

    Where `lanes`, an element is a vector of a number for each lane.
    """

    at: ir.Value
    shape: tuple[Number, ...]
    strides: tuple[Number, ...]
    kind: str = "real"
    lanes: bool = True
    over: int = 0  # bytes from an element to its reciprocal, if that is known


Field = tuple[int, tuple[int, ...], str, bool]  # first byte, shape, kind, whether of lanes


@dataclass(frozen=True)
class Record:
    """Arrays by name from an address on."""

    at: ir.Value
    fields: Mapping[str, Field]


@dataclass(frozen=True)
class Text:
    """A function as text, with the names that hold in it."""

    tree: ast.FunctionDef
    names: Mapping[str, Any]
    called: bool = False  # stays a function of its own


class Gone:
    """What a name stands for where nothing is known of it."""


GONE = Gone()
Env = dict[str, Any]  # values by name; under "%names" what else holds in a text


def wider(*kinds: str) -> str:
    """The kind that holds numbers of all these kinds."""
    return RANKS[max(map(RANKS.index, kinds))]
