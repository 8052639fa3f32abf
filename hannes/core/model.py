"""What printing and writing need to know of a hand, or of any other plant."""

from collections.abc import Mapping
from typing import Protocol, Self

from hannes.core.effect import Effect
from hannes.core.parameter import ParameterSet


class Model(Protocol):
    """Named values and effects: a hand, or any other plant."""

    @property
    def parameters(self) -> ParameterSet:
        """Values by full name, SI units."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Effects in the model, those at `off` included."""

    def with_effects(self, *effects: Effect) -> Self:
        """Return a copy whose model also has `effects`, at `off`."""

    def with_values(self, values: Mapping[str, float]) -> Self:
        """Return a copy with other SI values by full name; BadInput where they do not fit."""


def differences(model: Model, shipped: Model | None = None) -> dict[str, float]:
    """SI values by full name that are not those of `shipped`, or not the declared ones."""
    known = dict(shipped.parameters) if shipped else {}
    return {
        name: number
        for name, number in model.parameters.items()
        if number != known.get(name, model.parameters.declared[name].value)
    }
