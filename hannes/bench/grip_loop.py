"""Recognition, force and grip policy as one loop: a board's events in, set points out.

It has no port and no clock of its own, so that a live link, a benchmark in simulated time and a raw
log read again run the same code.
"""

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from hannes.bench.events import About, Event, Row
from hannes.bench.haptics import HapticCommand, HapticMemory, HapticSample, HapticSettings, haptic
from hannes.bench.live import Decision, LiveRecogniser
from hannes.bench.policy import GripMemory, GripSample, GripSettings, grip
from hannes.bench.release import Release
from hannes.recognition.model import Model


@dataclass(frozen=True)
class Force:
    """Force on the object [N] at board time [s], its 90 % band, and the residual.

    residual: distance of the measurement from the observer's model, in standard deviations;
    `warns`: whether the machine has left the model.
    """

    time: float
    value: float
    low: float
    high: float
    residual: float = 0.0
    warns: bool = False


class Observer(Protocol):
    """What estimates the force at every sample."""

    def feed(self, event: Event) -> Force | None:
        """Take one event of the board; return the force at a sample."""
        ...

    def begin(self) -> None:
        """Forget the object: a new grasp begins."""
        ...


@dataclass(frozen=True)
class GripPlan:
    """What the loop does: whether it limits, by which settings; force set point [N], 0 for none."""

    policy: bool = True
    force_wanted: float = 0.0
    settings: GripSettings = field(default_factory=GripSettings)
    haptics: HapticSettings = field(default_factory=HapticSettings)


@dataclass
class Said:
    """What came of one event; `released`: what was held is let go, and nothing new was met."""

    decisions: list[Decision] = field(default_factory=list)
    force: Force | None = None
    haptic: HapticCommand | None = None
    released: bool = False


class GripLoop:
    """Takes events and the command; `set_point` [rad] is what the board is to follow now.

    hand: numbers of its empty closure (known_hand.py), None for a hand that is not known.
    """

    def __init__(
        self,
        model: Model,
        plan: GripPlan | None = None,
        observer: Observer | None = None,
        hand: np.ndarray | None = None,
    ) -> None:
        self.plan = plan or GripPlan()
        self._recogniser, self._observer = LiveRecogniser(model, hand), observer
        self._border = model.border
        self._places: dict[str, int] = {}
        self._grip, self._haptic = GripMemory(), HapticMemory()
        self._last: float | None = None
        self._tick_time = 0.0  # s between two ticks, as the board says
        self._decision: Decision | None = None
        self._held: Decision | None = None  # the last that touched, until it is let go
        self._release = Release()
        self._force = Force(0.0, 0.0, 0.0, 0.0)
        self.set_point = 0.0

    def feed(self, event: Event, wanted: float) -> Said:
        """Take one event, while the command is `wanted` [rad]."""
        if isinstance(event, About):
            self._places = {name: k for k, name in enumerate(event.channels)}
            self._tick_time = 1.0 / event.rate if event.rate else 0.0
        elif isinstance(event, Row) and self._places:
            self._begin_again(event)
        decisions, is_open = self._recogniser.feed(event), self._release.is_open
        said = Said([] if is_open else decisions, released=is_open)
        if said.decisions:
            self._decision = said.decisions[-1]
        if self._observer is not None:
            said.force = self._observer.feed(event)
            self._force = said.force or self._force
        elif said.decisions and (found := said.decisions[-1].force) is not None:
            time = said.decisions[-1].board_time
            said.force = self._force = Force(time, found.value, found.low, found.high)
        if isinstance(event, Row):
            self._tick(event, wanted, said)
        return said

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the board's channels, in their order."""
        return tuple(self._places)

    @property
    def begun(self) -> bool:
        """Whether a sample came: before, nothing is known of where the hand is."""
        return self._last is not None

    @property
    def firm(self) -> bool:
        """Whether the policy holds the object firmly."""
        return self._grip.firm

    @property
    def uncertain(self) -> bool:
        """Whether the policy pressed on in doubt, so that the stiffness by the traces counts."""
        return self._grip.uncertain

    def _begin_again(self, row: Row) -> None:
        """Forget what was held before, where the hand turns to close once more."""
        if self._release.begins(row.values[self._places["position"]]):
            self._recogniser.begin(row.time)
            if self._observer is not None:
                self._observer.begin()

    def _tick(self, row: Row, wanted: float, said: Said) -> None:
        period = self._tick_time if self._last is None else max(row.time - self._last, 0.0)
        self._last = row.time
        position = row.values[self._places["position"]]
        held = self._holds(position)
        rigid = held.rigid if held else 0.5
        self._haptic, said.haptic = haptic(
            self.plan.haptics, self._haptic,
            HapticSample(period, held is not None, rigid, self._force.low if held else 0.0),
        )  # fmt: skip
        if not self.plan.policy:
            self.set_point = wanted
            return
        sample = GripSample(
            period, wanted, position, held is not None, held.touch_position if held else 0.0,
            rigid, self._force.value, self._force.high, self.plan.force_wanted,
            held.pressed.value / self._border if held and held.pressed else 0.0,
        )  # fmt: skip
        self._grip, point = grip(self.plan.settings, self._grip, sample)
        self.set_point = point if math.isfinite(point) else self.set_point

    def _holds(self, position: float) -> Decision | None:
        """What recognition last said of the object, until the hand has let it go."""
        if self._decision is not None and self._decision.touched:
            self._held = self._decision
        if self._held and self._release.lets_go(self._held.touch_position, position):
            self._held = self._decision = None
        return self._held
