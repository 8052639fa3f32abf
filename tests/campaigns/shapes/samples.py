"""What the shapes hold, and their registry."""

import importlib
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

RATE = 200.0  # Hz
LASTING = 1.2  # s
ENCODER, STEP = 2.0 * np.pi / 4096, 1e-3  # rad, A


@dataclass(frozen=True)
class Samples:
    """One run: time [s] from 0, reference and position [rad], current [A], all of shape (n,)."""

    time: np.ndarray
    reference: np.ndarray
    position: np.ndarray
    current: np.ndarray

    @property
    def rows(self) -> Iterator[tuple[float, float, float, float]]:
        """Rows of time, reference, position, current."""
        columns = (self.time, self.reference, self.position, self.current)
        return zip(*(each.tolist() for each in columns), strict=True)

    def run(self, number: int) -> "Samples":
        """Repeat 0, 1 or 2 of the same command."""
        return samples(number)


def samples(number: int = 0) -> Samples:
    """A hand that closes and opens again: position lags, the current answers to speed and load."""
    rng = np.random.default_rng(number)
    time = np.arange(round(LASTING * RATE)) / RATE
    asked = np.interp(time, [0.0, 0.1, 0.6, 1.0], [0.0, 0.0, 8.0, 0.0])
    lagging = np.interp(time - 0.05, time, asked, left=0.0)
    position = ENCODER * np.round(lagging / ENCODER)
    current = 0.3 * np.tanh(np.gradient(lagging, time)) + 0.05 * lagging
    current = STEP * np.round((current + 0.006 * rng.standard_normal(time.size)) / STEP)
    return Samples(time, np.round(asked, 6), np.round(position, 6), np.round(current, 4))


Builder = Callable[[Path, Samples], list[Path]]


@dataclass(frozen=True)
class Shape:
    """One shape: its builder, how many runs it holds, answers that only a person knows."""

    name: str
    build: Builder
    runs: int = 1
    answers: Mapping[str, str] = field(default_factory=dict)
    needs: str = ""


SHAPES: dict[str, Shape] = {}


def shape(
    runs: int = 1, answers: Mapping[str, str] | None = None, needs: str = ""
) -> Callable[[Builder], Builder]:
    """Register a builder; `answers`: texts of mapping.toml -> what a user writes there.

    `needs`: a library without which the shape cannot be made.
    """

    def registered(build: Builder) -> Builder:
        name = build.__name__
        SHAPES[name] = Shape(name, build, runs, answers or {}, needs)
        return build

    return registered


def all_shapes() -> Mapping[str, Shape]:
    """Every shape of the modules in this folder."""
    import shapes

    for module in sorted(each.name for each in pkgutil.iter_modules(shapes.__path__)):
        importlib.import_module(f"shapes.{module}")
    return SHAPES
