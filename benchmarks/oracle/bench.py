"""What the oracle simulates, once: empty campaigns, what effects change, noise, and slopes."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from benchmarks.oracle.features import BINS, names, vector
from benchmarks.oracle.shapes import Shape, shape_name
from benchmarks.oracle.store import Store
from benchmarks.truth.campaign import SHIPPED, Spread, make
from benchmarks.truth.parameters import NOMINAL, flat
from benchmarks.truth.protocol import PROTOCOLS, Condition
from benchmarks.truth.scatter import PLACES

EXACTLY, COMMON = Spread(0.0, "normal", 0.0, 0.0), Spread()
EMPTY, HANDS, STILL = 1_000_000, 2_000_000, 3_000_000  # first seeds; no study has these
STEP, PLACE_STEP, LATE = 0.02, 0.2e-3, 1e-3  # of a slope: relative; m; s
NONE: Shape = {}
CARRIED = ("wire_creep.rate",)  # what a run leaves to the next: no repeat may be left out


class Bench:
    """Vectors of one protocol, of hands with this spread."""

    def __init__(self, protocol: str, store: Store, spread: Spread = COMMON) -> None:
        self.name, self.store, self.spread = protocol, store, spread
        self.whole = PROTOCOLS[protocol]
        conditions = tuple(replace(each, repeats=1) for each in self.whole.conditions)
        self.once = replace(self.whole, conditions=conditions)

    @property
    def blocks(self) -> list[int]:
        """Length of each condition's part of a vector."""
        return [BINS * len(names(self.once, each)) for each in self.once.conditions]

    def empty(self, number: int) -> np.ndarray:
        """An empty campaign of a scattered hand."""

        def run() -> np.ndarray:
            return vector(make(self.whole, EMPTY + number, spread=self.spread), self.whole)

        return self._kept(f"empty-{number}", run)

    def change(self, effect: str, size: float, number: int, shape: Shape = NONE) -> np.ndarray:
        """What an effect of this size changes in one hand's campaign, all noise the same."""
        plan = self.whole if effect in CARRIED else self.once
        kind = f"{'whole' if effect in CARRIED else 'once'}-{number}"

        def run(hidden: Mapping[str, float]) -> np.ndarray:
            return vector(make(plan, HANDS + number, hidden, self.spread), plan)

        rounded = f"{size:.6g}"
        hidden = {effect: float(rounded), **shape}
        changed = self._kept(f"{effect}={rounded}{shape_name(shape)}-{kind}", lambda: run(hidden))
        return changed - self._kept(kind, lambda: run({}))

    def noise(self, count: int = 12) -> np.ndarray:
        """Variance of one run's features where nothing scatters but the sensors."""
        return np.var([self._still(k) for k in range(count)], axis=0, ddof=1)

    def derivative(self, name: str, of: Condition | None = None) -> np.ndarray:
        """Change of one run's features per relative change of a parameter (per m of a place).

        of: the condition whose own object has the parameter; else the hand has it.
        """
        kept = f"slope-{name}{f'-{of.stem}' if of else ''}"
        step = PLACE_STEP if name in PLACES else STEP
        return (self._kept(kept, lambda: self._moved(name, of)) - self._still()) / step

    def start_offset(self) -> np.ndarray:
        """Change of one run's features per second that it starts late."""

        def run() -> np.ndarray:
            made = make(self.once, STILL, spread=replace(EXACTLY, timing=LATE))
            start_offset = [each["late_s"] for each in made.answer["runs"]]
            return (vector(made, self.once) - self._still()) / np.repeat(start_offset, self.blocks)

        return self._kept("late", run)

    def _still(self, number: int = 0) -> np.ndarray:
        return self._kept(
            f"still-{number}",
            lambda: vector(make(self.once, STILL + number, spread=EXACTLY), self.once),
        )

    def _moved(self, name: str, of: Condition | None) -> np.ndarray:
        plan, hand = self.once, SHIPPED
        if of is None:
            hand += f'[parameters]\n"{name}" = {_stepped(name, flat(NOMINAL).get(name, 1.0))!r}\n'
        else:
            key = name.partition(".")[2]
            moved = replace(of, thing={**of.thing, key: _stepped(name, of.thing[key])})
            conditions = tuple(moved if each.name == of.name else each for each in plan.conditions)
            plan = replace(plan, conditions=conditions)
        return vector(make(plan, STILL, spread=EXACTLY, hand=hand), plan)

    def _kept(self, name: str, run: Callable[[], np.ndarray]) -> np.ndarray:
        apart = f"-fingers-{self.spread.finger:g}" if self.spread.finger else ""
        return self.store.kept(f"{self.name}{apart}/{name}", run)


def _stepped(name: str, value: float) -> float:
    return value + PLACE_STEP if name in PLACES else value * (1.0 + STEP)
