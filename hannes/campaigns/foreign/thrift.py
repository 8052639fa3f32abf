"""The compact protocol of Thrift, in which Parquet writes its heads: fields by their numbers.

https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md
"""

import struct
from typing import Any

TRUE, FALSE, BYTE, DOUBLE, BINARY, LIST, SET, MAP, STRUCT = 1, 2, 3, 7, 8, 9, 10, 11, 12
WHOLE = (4, 5, 6)  # integers of 16, 32, 64 bits
DEEPEST = 30  # structures and lists in one another


class Reader:
    """Reads values one after another from bytes; ValueError or IndexError where they are none."""

    def __init__(self, data: bytes, at: int = 0) -> None:
        self.data, self.at = data, at

    def fields(self, depth: int = 0) -> dict[int, Any]:
        """The fields of a structure by number; those of kinds that are not asked for are None."""
        found, number = dict[int, Any](), 0
        while head := self._byte():
            step = head >> 4
            number = number + step if step else self._whole()
            found[number] = self._value(head & 15, depth + 1)
        return found

    def _value(self, kind: int, depth: int, in_list: bool = False) -> Any:
        if depth > DEEPEST:
            raise ValueError("nested too deep")
        if kind in (TRUE, FALSE):
            return self._byte() == TRUE if in_list else kind == TRUE
        if kind in WHOLE:
            return self._whole()
        if kind in (BYTE, DOUBLE, BINARY):
            return self._skip({BYTE: 1, DOUBLE: 8}.get(kind) or self._unsigned())
        if kind in (LIST, SET):
            return self._list(depth)
        if kind == STRUCT:
            return self.fields(depth)
        raise ValueError(f"a value of kind {kind}")

    def _list(self, depth: int) -> list[Any]:
        head = self._byte()
        count = head >> 4 if head >> 4 < 15 else self._unsigned()
        if count > len(self.data):
            raise ValueError("a list longer than the file")
        return [self._value(head & 15, depth + 1, True) for _ in range(count)]

    def _byte(self) -> int:
        self.at += 1
        return self.data[self.at - 1]

    def _skip(self, size: int) -> None:
        self.at += size
        if self.at > len(self.data):
            raise ValueError("a text longer than the file")

    def _unsigned(self) -> int:
        value = shift = 0
        while (byte := self._byte()) > 127:
            value |= (byte & 127) << shift
            shift += 7
            if shift > 63:
                raise ValueError("a number of more than 64 bits")
        return value | byte << shift

    def _whole(self) -> int:
        value = self._unsigned()
        return value >> 1 if not value & 1 else -(value >> 1) - 1


def whole_u32(data: bytes) -> int:
    """Four bytes as a number, lowest first."""
    return int(struct.unpack("<I", data)[0])
