"""What a simulation returns: states over time, outputs on demand, and how it ended."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from enum import Enum
from functools import cached_property
from typing import Any

import numpy as np

from hannes.core import former_names
from hannes.core.by_value import ByValue
from hannes.core.effect import Effect
from hannes.core.errors import BadInput, ComputationFailed, nearest
from hannes.core.layout import Layout
from hannes.simulation.compiler.assemble import Compiled, assemble
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.model import EQUATIONS


class Outcome(Enum):
    """How a simulation ended."""

    COMPLETED = "completed"
    SOLVER_GAVE_UP = "the solver gave up"
    NOT_FINITE = "the state is no longer finite"


@dataclass(frozen=True)
class Cost:
    """What a simulation took: evaluations, Jacobians, smooth parts and solver time [s]."""

    evaluations: int = 0
    jacobians: int = 0
    steps: int = 0
    seconds: float = field(default=0.0, compare=False)

    def __add__(self, other: "Cost") -> "Cost":
        return Cost(
            self.evaluations + other.evaluations,
            self.jacobians + other.jacobians,
            self.steps + other.steps,
            self.seconds + other.seconds,
        )


def failed(title: str, outcome: Outcome, message: str, time: np.ndarray) -> ComputationFailed:
    """The error for a run that ended after the samples at `time`, with what to try."""
    last = time[-1] if time.size else 0.0
    return ComputationFailed(
        f"{title}: {outcome.value} at {last:.4f} s "
        f"(solver: {message}); try a smaller rtol, method = Radau, or softer parameters"
    )


@former_names.attributes({"holds": "memories"})
@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(ByValue, Mapping[str, np.ndarray]):
    """States at the sample times, shape (n, states); outputs are computed when asked for.

    A mapping as a Recording is: `trajectory["current"]`, `in`, iteration, `keys`, `items`, `get`,
    over time, all states and all outputs. Its length is the number of samples.

    Where the outcome is not COMPLETED the samples end before the failure and `message` keeps
    the solver's own words.
    """

    experiment: Experiment
    time: np.ndarray
    states: np.ndarray
    outcome: Outcome
    message: str
    cost: Cost
    compiled: Compiled
    parameters: np.ndarray
    knots: np.ndarray
    memories: np.ndarray

    def __repr__(self) -> str:
        end = f"{self.time[-1]:g} s" if self.time.size else "none"
        count = f"{self.time.size} samples to {end}"
        return f"Trajectory({self.experiment.title}: {count}, {self.outcome.value})"

    def __reduce__(self) -> tuple[Any, ...]:
        kept = {each.name: getattr(self, each.name) for each in fields(self)}
        del kept["compiled"]  # machine code stays where it is
        return _again, (self.compiled.effects, kept)

    def require(self) -> "Trajectory":
        """Return itself where completed; raise ComputationFailed with what to try otherwise."""
        if self.outcome is Outcome.COMPLETED:
            return self
        raise failed(self.experiment.title, self.outcome, self.message, self.time)

    @cached_property
    def outputs(self) -> np.ndarray:
        """All outputs at the sample times, shape (n, outputs); see hand/variables.py."""
        observe: Callable[..., np.ndarray] = self.compiled.observed.observe
        return observe(self.time, self.states, self.parameters, self.knots, self.memories)

    def __getitem__(self, name: str) -> np.ndarray:
        """Time, an output or a state, shape (n,) or (n, size); BadInput when unknown."""
        if name == "time":
            return self.time
        if name in self.compiled.states and name not in self.compiled.outputs:
            return self._column(self.states, self.compiled.states, name)
        return self._column(self.outputs, self.compiled.outputs, name)

    def get(self, name: str, default: Any = None) -> Any:
        """Return time, an output or a state, or `default` where there is none of that name."""
        return self[name] if name in self else default

    def __contains__(self, name: object) -> bool:
        return name == "time" or name in self.compiled.states or name in self.compiled.outputs

    def __iter__(self) -> Iterator[str]:
        slots = (*self.compiled.states.slots, *self.compiled.outputs.slots)
        return iter(dict.fromkeys(["time", *(each.name for each in slots)]))

    def __len__(self) -> int:
        return len(self.time)

    def __bool__(self) -> bool:
        return True

    @staticmethod
    def _column(table: np.ndarray, layout: Layout, name: str) -> np.ndarray:
        part: np.ndarray = table[:, layout[name]]
        return part if layout.slot(name).axis else part[:, 0]


def _again(effects: tuple[Effect, ...], kept: dict[str, Any]) -> Trajectory:
    """A pickled trajectory, with the model of a hand with these effects."""
    return Trajectory(compiled=assemble(EQUATIONS, effects), **kept)


@dataclass(frozen=True, eq=False)
class Grasp(ByValue):
    """One grasp of a batch: `number` counts from 0, `grasp[name]` is a channel asked for.

    Channels have the shape (n,) or (n, size), n the samples in `time` [s]. Where the outcome is
    not COMPLETED they end before the failure, which `message` states in the solver's words.
    """

    number: int
    title: str
    time: np.ndarray = field(repr=False)
    channels: Mapping[str, np.ndarray] = field(repr=False)
    outcome: Outcome
    message: str
    cost: Cost

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a channel; BadInput where it was not asked for."""
        if name not in self.channels:
            raise BadInput(f'channel "{name}" was not asked for{nearest(name, self.channels)}')
        return self.channels[name]

    def require(self) -> "Grasp":
        """Return itself where completed; raise ComputationFailed with what to try otherwise."""
        if self.outcome is Outcome.COMPLETED:
            return self
        raise failed(f"{self.title}, grasp {self.number}", self.outcome, self.message, self.time)
