"""Elements, parts and sizes of arrays, whose elements are numbers of one lane or of all."""

import ast
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from llvmlite import ir

from hannes.simulation.compiler.lanes.arithmetic import lane_of
from hannes.simulation.compiler.lanes.library import Library
from hannes.simulation.compiler.lanes.values import (
    POINTER,
    TYPES,
    Array,
    NotInLanes,
    Number,
    Record,
)


class Arrays(Library):
    """What can be done with them; under `mask` only its lanes are stored to."""

    def __init__(self, module: ir.Module, width: int) -> None:
        super().__init__(module, width)
        self.mask: Number | None = None

    def rows(
        self, at: ir.Value, shape: Sequence[Any], kind: str = "real", lanes: bool = True
    ) -> Array:
        """An array in C order."""
        sizes = tuple(n if isinstance(n, Number) else self.known(int(n)) for n in shape)
        strides, step = list[Number](), self.known(1)
        for size in reversed(sizes):
            strides.insert(0, step)
            step = self.binary(ast.Mult(), step, size)
        return Array(at, sizes, tuple(strides), kind, lanes)

    def field(self, record: Record, name: str) -> Array:
        """One of its arrays; that of parameters knows where their reciprocals are."""
        offset, shape, kind, lanes = record.fields[name]
        step = ir.Constant(TYPES["whole"], offset)
        at = self.builder.gep(record.at, [step], source_etype=ir.IntType(8))
        found = self.rows(at, shape, kind, lanes)
        if name == "p" and "p_over" in record.fields:
            return replace(found, over=record.fields["p_over"][0] - offset)
        return found

    def constant(self, value: np.ndarray) -> Array:
        """An array that is known."""
        kind = {"f": "real", "i": "whole", "u": "whole", "b": "whole"}[value.dtype.kind]
        flat = [x if kind == "real" else int(x) for x in value.ravel().tolist()]
        of = ir.ArrayType(TYPES[kind], len(flat))
        name = self.module.get_unique_name("known")
        held = ir.GlobalVariable(self.module, of, name)
        held.global_constant, held.linkage = True, "internal"
        held.initializer = ir.Constant(of, [ir.Constant(TYPES[kind], x) for x in flat])
        return self.rows(ir.Constant(POINTER, held.get_reference()), value.shape, kind, False)

    def part(self, array: Array, places: Sequence[Any]) -> Any:
        """An element's place, or a part: `places` are whole numbers or (start, stop)."""
        at, shape, strides = array.at, [], []
        offset = self.known(0)
        for n, size in enumerate(array.shape):
            place = places[n] if n < len(places) else (self.known(0), size)
            if isinstance(place, tuple):
                start, stop = place[0] or self.known(0), place[1] or size
                length = self.binary(ast.Sub(), stop, start)
                if self.width == 1 and size.known is None and length.known is not None:
                    length = Number(self.hidden(length.ir), "whole")  # see `unknown` in pointers.py
                shape.append(length)
                strides.append(array.strides[n])
            else:
                start = self.as_kind(place, "whole")
                if start.known is not None and start.known < 0:
                    start = self.binary(ast.Add(), size, start)
            step = self.binary(ast.Mult(), start, array.strides[n])
            offset = self.binary(ast.Add(), offset, step)
        if offset.known != 0:
            if offset.varying:
                raise NotInLanes("a place that differs from lane to lane")
            at = self.builder.gep(at, [offset.ir], source_etype=self._element(array))
        return Array(at, tuple(shape), tuple(strides), array.kind, array.lanes, array.over)

    def of_lane(self, array: Array, lane: Number) -> Array:
        """One lane's numbers of an array of all: each as far from the next as vectors are."""
        if not array.lanes:
            raise NotInLanes("a lane of what is the same for all")
        at = self.builder.gep(array.at, [lane.ir], source_etype=TYPES[array.kind])
        width = self.known(self.width)
        strides = tuple(self.binary(ast.Mult(), each, width) for each in array.strides)
        return Array(at, array.shape, strides, array.kind, False)

    def hidden(self, value: ir.Value) -> ir.Value:
        """The same value, of which the compiler knows nothing."""
        kind = ir.FunctionType(value.type, [value.type])
        return self.builder.asm(kind, "", "=r,0", [value], False)

    def _element(self, array: Array) -> ir.Type:
        return self.type_of(array.kind, array.lanes)

    def read(self, place: Array) -> Number:
        """The number there."""
        made = self.builder.load(place.at, typ=self._element(place))
        if place.kind == "byte":  # a truth as numpy keeps it
            return Number(self.builder.icmp_unsigned("!=", made, made.type(0)), "truth")
        over = None
        if place.over:
            step = ir.Constant(TYPES["whole"], place.over)
            over = self.builder.gep(place.at, [step], source_etype=ir.IntType(8))
        return Number(made, place.kind, place.lanes, over=over)

    def gathered(self, array: Array, places: Sequence[Number]) -> Number:
        """The number at another place for each lane; one that is not asked may hold any place."""
        offset = self.known(0)
        for place, size, stride in zip(places, array.shape, array.strides, strict=True):
            last = self.binary(ast.Sub(), size, self.known(1))
            inside = self.extreme("min", [self.extreme("max", [place, self.known(0)]), last])
            offset = self.binary(ast.Add(), offset, self.binary(ast.Mult(), inside, stride))
        found: ir.Value = ir.Constant(self.type_of(array.kind, True), ir.Undefined)
        for n in range(self.width):
            lane = lane_of(n)
            at = self.builder.extract_element(offset.ir, lane)
            at = self.builder.gep(array.at, [at], source_etype=self._element(array))
            if array.lanes:
                at = self.builder.gep(at, [lane], source_etype=TYPES[array.kind])
            one = self.builder.load(at, typ=TYPES[array.kind])
            found = self.builder.insert_element(found, one, lane)
        return Number(found, array.kind, True)

    def write(self, place: Array, value: Number) -> None:
        """Store a number there, of lanes that are not masked."""
        if value.varying and not place.lanes:
            raise NotInLanes("one place for what differs from lane to lane")
        value = self.as_kind(value, place.kind, place.lanes)
        if self.mask is not None and place.lanes:
            value = self.select(self.mask, value, self.read(place))
        self.builder.store(value.ir, place.at)
