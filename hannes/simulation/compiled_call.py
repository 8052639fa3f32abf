"""What the grasps of one compiled call share, and what the call leaves of each."""

import functools
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.control.firmware_memory import MEMORY
from hannes.core.errors import BadInput, nearest
from hannes.core.kernels.jit import compiles
from hannes.core.layout import Layout
from hannes.simulation.compiler.assemble import Compiled
from hannes.simulation.compiler.grasp_loop import ASTRAY, MOST
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.integrate import tolerances
from hannes.simulation.rodas.step import NOT_FINITE, TOO_MANY
from hannes.simulation.trajectory import Cost, Outcome


@dataclass(frozen=True)
class Ran:
    """What a compiled call leaves, see `grasps` in entry_points.py; and the seconds it took."""

    rows: np.ndarray
    memories: np.ndarray
    kept: np.ndarray
    counts: np.ndarray
    seconds: float


@dataclass(frozen=True, eq=False)
class Plan:
    """Model, reference, ends of its smooth parts, sample times [s], tolerances, what is kept."""

    compiled: Compiled
    knots: np.ndarray
    bounds: np.ndarray
    times: np.ndarray
    sampled: bool
    rtol: float
    atol: np.ndarray
    channels: tuple[str, ...]
    columns: np.ndarray
    needed: np.ndarray

    @staticmethod
    def of(
        compiled: Compiled, experiment: Experiment, rtol: float, channels: Sequence[str] = ()
    ) -> "Plan":
        """Plan `experiment`, keeping `channels`; BadInput for an unknown one."""
        reference = experiment.reference
        inside = {float(t) for t in reference.knots[0] if 0.0 < t < experiment.duration}
        ends = sorted(inside) if reference.kinked else []
        columns = np.array([k for name in channels for k in _places(compiled, name)], np.int64)
        return Plan(
            compiled,
            reference.knots,
            np.array([*ends, float(experiment.duration)]),
            experiment.times,
            experiment.controller == "sampled",
            rtol,
            tolerances(compiled, rtol),
            tuple(channels),
            columns,
            compiled.needed.by(columns),
        )

    def run(
        self,
        vectors: np.ndarray,
        starts: np.ndarray,
        stop: np.ndarray | None = None,
        path: np.ndarray | None = None,
    ) -> Ran:
        """Run one grasp for each row of `vectors`; `starts` (m, states) become those at the end.

        path: all by the steps of the first one, or by those that it holds, see `grasps` in
        entry_points.py.
        """
        size, count = self.times.size, vectors.shape[0]
        ran = Ran(
            np.empty((size, starts.shape[1])),
            np.zeros((size, MEMORY)),
            np.empty((count, self.columns.size, size)),
            np.zeros((count, 6), np.int64),
            time.perf_counter(),
        )
        given = (vectors, starts, self.knots, self.bounds, self.periods(vectors), self.times)
        stop = np.zeros(1, np.bool_) if stop is None else stop
        path = np.zeros(1) if path is None else path
        with np.errstate(all="ignore"):  # where nothing is compiled
            self.compiled.fast.grasps(
                *given, self.columns, self.needed, self.rtol, self.atol, stop, path, 0,
                ran.rows, ran.memories, ran.kept, ran.counts,
            )  # fmt: skip
        return replace(ran, seconds=time.perf_counter() - ran.seconds)

    def make_ready(self) -> "Plan":
        """Compile, where that is still to be done, and say so; the clock is not to count it."""
        say_when_compiling(self.compiled, "grasps")
        parameters, states = self.compiled.parameters.size, self.compiled.states.size
        self.run(np.zeros((0, parameters)), np.zeros((0, states)))
        return self

    def periods(self, vectors: np.ndarray) -> np.ndarray:
        """Period of the sampled controller [s], 0 for the continuous one, shape (m,)."""
        if not self.sampled:
            return np.zeros(vectors.shape[0])
        return np.ascontiguousarray(vectors[:, self.compiled.parameters["controller_period"].start])

    def named(self, kept: np.ndarray) -> dict[str, np.ndarray]:
        """Channels by name, (n,) or (n, size), of the rows in `kept` (columns, n)."""
        named, start = {}, 0
        for name in self.channels:
            slot = _layout(self.compiled, name).slot(name)
            rows = kept[start : start + slot.size]
            named[name] = rows.T if slot.axis else rows[0]
            start += slot.size
        return named

    def cost(self, counts: np.ndarray, p: np.ndarray, seconds: float) -> Cost:
        """What a grasp took, by its counts."""
        parts = self.bounds.size
        if self.sampled:
            parts = round(float(self.bounds[-1] / self.periods(p[np.newaxis])[0]))
        return Cost(int(counts[0]), int(counts[1]), parts, seconds)


def _layout(compiled: Compiled, name: str) -> Layout:
    """Outputs or states, whichever has the channel."""
    for layout in (compiled.outputs, compiled.states):
        if name in layout:
            return layout
    known = [slot.name for slot in (*compiled.outputs.slots, *compiled.states.slots)]
    raise BadInput(f'no channel "{name}"{nearest(name, known)}')


def _places(compiled: Compiled, name: str) -> range:
    """Places of a channel among outputs, then states."""
    place = _layout(compiled, name)[name]
    first = 0 if name in compiled.outputs else compiled.outputs.size
    return range(first + place.start, first + place.stop)


def ended(counts: np.ndarray) -> tuple[Outcome, str]:
    """How a grasp ended, and in which words."""
    failure = int(counts[4])
    if failure == 0:
        return Outcome.COMPLETED, "completed"
    from hannes.simulation.rodas.scipy_solver import MESSAGES

    outcome = Outcome.NOT_FINITE if failure == NOT_FINITE else Outcome.SOLVER_GAVE_UP
    own = {TOO_MANY: f"More than {MOST} steps.", ASTRAY: "Not near the grasp whose steps it takes."}
    return outcome, {**MESSAGES, **own}[failure]


@functools.cache
def say_when_compiling(compiled: Compiled, entry: str) -> None:
    """Say once on standard error that an entry point is about to be compiled."""
    if compiles() and not compiled.is_warm(entry):
        print("hannes: compiling the model, once (5 to 20 s)", file=sys.stderr, flush=True)
