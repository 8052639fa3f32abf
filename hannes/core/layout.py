"""What a plant's compiled equations read and write: states, channels and outputs by name."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from hannes.core.errors import BadInput, nearest


@dataclass(frozen=True)
class Slot:
    """A named run of numbers: `size` of them along `axis` ("" for a single number).

    `tolerance` is the absolute solver tolerance of a state [unit]. `room` is the number of elements
    that the slot occupies in the plain array, where that is more than its size.
    """

    name: str
    unit: str
    doc: str
    axis: str = ""
    size: int = 1
    tolerance: float = 1e-6
    room: int = 0


@dataclass(frozen=True)
class Layout:
    """Position of each slot in a plain array."""

    slots: tuple[Slot, ...]
    _places: Mapping[str, slice] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        places, start = {}, 0
        for slot in self.slots:
            places[slot.name] = slice(start, start + slot.size)
            start += max(slot.size, slot.room)
        object.__setattr__(self, "_places", places)

    def __contains__(self, name: object) -> bool:
        return name in self._places

    def __getitem__(self, name: str) -> slice:
        if name not in self._places:
            raise BadInput(f'no slot named "{name}"{nearest(name, self._places)}')
        return self._places[name]

    def slot(self, name: str) -> Slot:
        """Return the declaration of `name`; raise BadInput when unknown."""
        place = self[name]
        return next(slot for slot in self.slots if self._places[slot.name] == place)

    @property
    def size(self) -> int:
        """Length of the plain array."""
        return sum(max(slot.size, slot.room) for slot in self.slots)

    @cached_property
    def tolerances(self) -> np.ndarray:
        """Declared tolerance of each number, shape (size,)."""
        return np.array([slot.tolerance for slot in self.slots for _ in range(slot.size)])

    @cached_property
    def _found_at(self) -> tuple[tuple[str, int | slice], ...]:
        """Names, each with its place: of a single number its index."""
        places = self._places
        return tuple(
            (slot.name, places[slot.name] if slot.axis else places[slot.name].start)
            for slot in self.slots
        )

    def named(self, row: np.ndarray) -> dict[str, Any]:
        """Numbers of `row` (size,) by name: floats, and views of it where slots have an axis."""
        numbers = row.tolist()  # at once: to take each out of the array costs ten times as much
        return {
            name: row[at] if isinstance(at, slice) else numbers[at] for name, at in self._found_at
        }

    def extended(self, slots: Iterable[Slot]) -> "Layout":
        """Return a layout with further slots at its end."""
        return Layout((*self.slots, *slots))

    def text(self, name: str) -> str:
        """Subscript of a slot in generated code: `[7]` or `[7:12]`."""
        place, slot = self[name], self.slot(name)
        return f"[{place.start}]" if not slot.axis else f"[{place.start}:{place.stop}]"
