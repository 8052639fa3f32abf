"""What every plant outside the hand is: parameters, effects in its model, and easy answers.

`PlainPlant` and `CompiledPlant` say how such a plant moves.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar, Self

import numpy as np

from hannes.core.by_value import ByValue
from hannes.core.effect import Effect, joined
from hannes.core.parameter import Parameter, ParameterSet, group
from hannes.core.ranged import Bounds, ranged
from hannes.core.recording.recording import Recording
from hannes.plants.protocol import shown


class PlantWithEffects(ByValue, ABC):
    """Base of plants: parameters of the machine and of effects, and answers for a small machine.

    base:   parameters of the machine itself, full names ("spring.stiffness")
    ranges: an effect's parameter, by full name -> its bounds on this machine [SI]

    The other attributes are those of the protocol, hannes/plants/protocol.py.
    """

    name: str = ""
    channels: Mapping[str, str] = {}
    required: tuple[str, ...] = ()
    judged: tuple[str, ...] = ()
    base: ClassVar[tuple[Parameter, ...]] = ()
    ranges: ClassVar[Mapping[str, Bounds]] = {}
    free: Mapping[str, float] = {}
    block: float = 1.0

    def __init__(self, effects: tuple[Effect, ...] = ()) -> None:
        self.effects = tuple(ranged(each, self.ranges) for each in effects)
        own = (p for effect in self.effects for p in group(effect.name, *effect.parameters))
        self.parameters = ParameterSet((*self.base, *own))

    def __hash__(self) -> int:
        return hash((type(self), self.effects))

    def __repr__(self) -> str:
        return shown(self)

    def with_effects(self, *effects: Effect) -> Self:
        """Return a plant whose model has `effects` too, within its own `ranges`."""
        grown = type(self)(joined(self.effects, effects))
        return grown.with_values(dict(self.parameters))

    def with_values(self, values: Mapping[str, float]) -> Self:
        """Return a plant with other nominal values [SI]; BadInput on unknown name or bounds."""
        changed = type(self)(self.effects)
        changed.parameters = self.parameters.with_values(values)
        return changed

    @abstractmethod
    def accepts(self, effect: Effect) -> str:
        """Return why the plant cannot carry `effect`, or an empty string where it can."""

    @abstractmethod
    def simulate(
        self, parameters: Mapping[str, float], recording: Recording
    ) -> dict[str, np.ndarray]:
        """Channels at the recording's times, shape (n,)."""

    def same_run(self, recording: Recording) -> bytes:
        """Equal where the times and the required channels are."""
        return b"".join(recording[name].tobytes() for name in ("time", *self.required))

    def judged_part(self, recording: Recording) -> np.ndarray:
        """Every sample is compared."""
        return np.ones(len(recording), bool)

    def phases(self, recording: Recording) -> dict[str, np.ndarray]:
        """One part: the whole run."""
        return {"run": np.ones(len(recording), bool)}
