"""A start for a plant of your own in plain Python: say what it is and simulate it, no more.

Subclass `PlainPlant`, fill the attributes, write `simulate`: the rest of the protocol
(hannes/plants/protocol.py) is here, with answers that suit a small machine and can be overridden.
docs/tutorials/your-machine.md walks through one. For compiled equations see `CompiledPlant`.
"""

import math
from collections.abc import Callable, Mapping
from operator import itemgetter
from typing import Any, ClassVar

import numpy as np

from hannes.core.effect import Effect, Term
from hannes.core.errors import BadInput
from hannes.core.kernels.jit import plain
from hannes.core.parameter import ParameterSet
from hannes.core.recording.recording import Recording
from hannes.plants.with_effects import PlantWithEffects


class PlainPlant(PlantWithEffects):
    """Plant: base class of machines simulated in plain Python, with effects or without.

    open:  quantity that effects may add to -> what their kernels may read there, in the order in
           which `simulate` hands it over

    The other attributes are those of PlantWithEffects and of the protocol.
    """

    open: ClassVar[Mapping[str, tuple[str, ...]]] = {}

    def accepts(self, effect: Effect) -> str:
        """Return why the plant cannot carry `effect`, or an empty string where it can."""
        if effect.states:
            return f"it has states of its own ({effect.states[0].name}), which need assemble.py"
        for term in effect.terms:
            for channel in term.writes:
                if channel not in self.open:
                    return f"it needs a channel {channel}, which this plant does not have"
                known = {*self.open[channel], *self._names(effect)}
                for name in term.arguments:
                    if name not in known:
                        return f"it reads {name}, which this plant does not have"
        return ""

    def added(self, channel: str, values: Mapping[str, float]) -> Callable[..., float]:
        """Return what effects add to `channel`, as a function of what they read there (see `open`).

        `values` override the nominal parameters, as in `simulate`. The function raises BadInput
        where it gets another number of values than `open` lists.
        """
        parameters, reads = self.parameters.with_values(values), self.open[channel]
        calls = [
            _bound(term, term.writes.index(channel), self._fixed(effect, parameters), reads)
            for effect in self.effects
            for term in effect.terms
            if channel in term.writes
        ]

        size = len(reads)

        def all_of(*now: float) -> float:
            if len(now) != size:
                what = f"the effects at {channel} are given {len(now)} values"
                raise BadInput(f"{what}: expected {', '.join(reads)}, as `open` lists them")
            total = 0.0  # a machine asks this at every step: no generator is made for it
            for call in calls:
                total += call(now)
            return total

        return all_of

    def _names(self, effect: Effect) -> dict[str, str]:
        """A kernel's argument names for parameters -> their full names."""
        found = {each.name.replace(".", "_"): each.name for each in self.base}
        return found | {each.name: effect.full_name(each.name) for each in effect.parameters}

    def _fixed(self, effect: Effect, parameters: ParameterSet) -> dict[str, float]:
        return {name: parameters[full] for name, full in self._names(effect).items()}

    def simulate(
        self, parameters: Mapping[str, float], recording: Recording
    ) -> dict[str, np.ndarray]:
        """Channels at the recording's times, shape (n,); to be written by the subclass."""
        name = self.name or type(self).__name__
        raise BadInput(f"the plant {name} does not say how it moves: write its method simulate")


def _bound(
    term: Term, place: int, fixed: Mapping[str, float], reads: tuple[str, ...]
) -> Callable[[tuple[float, ...]], float]:
    """Return a term's share of one channel as a function of the quantities read."""
    function: Callable[..., Any] = plain(term.kernel)
    several, names = len(term.writes) > 1, term.arguments
    constants = tuple(fixed.get(name) for name in names)
    places = [reads.index(n) if n in reads else len(reads) + k for k, n in enumerate(names)]
    chosen = itemgetter(*places) if len(places) > 1 else lambda known: [known[k] for k in places]

    def call(now: tuple[float, ...]) -> float:
        try:
            found = function(*chosen(now + constants))
        except (ArithmeticError, ValueError):  # plain Python stops where compiled code goes on
            return math.nan
        return float(found[place] if several else found)

    return call
