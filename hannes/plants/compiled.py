"""A start for a plant of your own whose equations are compiled: it takes every effect that fits.

Subclass `CompiledPlant`, write its equations in a module and what they read and write as
`compiled_from`, and `simulate`: the rest of the protocol is here, and can be overridden.
docs/how-to/write-a-plant.md walks through one.
"""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import BadInput, ComputationFailed
from hannes.core.recording.recording import Recording
from hannes.plants.with_effects import PlantWithEffects
from hannes.simulation.compiler.assemble import Compiled, Equations, assemble


class CompiledPlant(PlantWithEffects):
    """Plant: base class of machines whose equations become machine code, effects included.

    compiled_from: their text and what it reads and writes, see Equations
    """

    compiled_from: ClassVar[Equations]

    @property
    def compiled(self) -> Compiled:
        """Entry points with the effects of its model; compiled once for each set of effects."""
        return assemble(self.compiled_from, self.effects)

    def equations(self) -> str:
        """Text of the assembled equations, effects included."""
        return self.compiled.text

    def accepts(self, effect: Effect) -> str:
        """Return why the plant cannot carry `effect`, or an empty string where it can."""
        return self.compiled_from.accepts(effect)

    def packed(self, parameters: Mapping[str, float]) -> np.ndarray:
        """The nominal values with others in their place [SI], as compiled code reads them."""
        return self.parameters.with_values(parameters).vector()

    def simulate(
        self, parameters: Mapping[str, float], recording: Recording
    ) -> dict[str, np.ndarray]:
        """Channels at the recording's times, shape (n,); to be written by the subclass."""
        name = self.name or type(self).__name__
        raise BadInput(f"the plant {name} does not say how it runs: write its method simulate")

    def run(
        self,
        parameters: Mapping[str, float],
        times: np.ndarray,
        reference: np.ndarray,
        start: Sequence[float],
        step: float,
    ) -> dict[str, np.ndarray]:
        """Outputs by name, shape (n,) each, of a run by steps that hold a machine at rest.

        For a machine whose first two states are an angle (or a position) and its rate. Only these
        are implicit: further states follow once a step, and a second mass may gain energy so.
        parameters: in place of nominal values [SI];  times: [s], shape (n,)
        reference: times and values, shape (2, knots);  start: of its own states
        step: of integration at most [s]. Raises ComputationFailed where it runs away, BadInput
        where it is another kind of machine.
        """
        if not (self.compiled_from.states.size >= max(2, len(start)) and step > 0.0):
            raise BadInput(
                f"the plant {self.name} cannot run by held steps: these take an angle and its rate "
                "as first states, a start of no more states than there are, and a step above 0 s; "
                "give Equations entry points of your own (docs/how-to/write-a-plant.md)"
            )
        p, states = self.packed(parameters), np.zeros((times.size, self.compiled.states.size))
        begun = np.zeros(states.shape[1])
        begun[: len(start)] = start
        self.compiled.fast.held_steps(times, begun, p, reference, step, states)
        memories = np.zeros((times.size, self.compiled_from.memory))
        return self.observed(times, states, p, reference, memories)

    def observed(self, times: np.ndarray, states: np.ndarray, *given: Any) -> dict[str, np.ndarray]:
        """Outputs by name, shape (n,) each, of states (n, states) at times [s].

        given: parameters as `packed` has them, reference (2, knots), and memory of each sample
        (n, k). Raises ComputationFailed where any of it is not finite.
        """
        rows, layout = self.compiled.observed.observe(times, states, *given), self.compiled.outputs
        if not (np.isfinite(states).all() and np.isfinite(rows).all()):
            raise ComputationFailed(f"the simulated {self.name} runs away; check its values")
        return {slot.name: rows[:, layout[slot.name]][:, 0] for slot in layout.slots}
