"""One tick of the firmware a call: what virtual boards, grip policies and observers stand on.

The numbers are those of `simulate` with the sampled controller, to the bit. Only the sample
at the experiment's end is not: `simulate` ends before the tick there, and keeps the duty before.
"""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from hannes.control.firmware_memory import MEMORY, READING_AGE
from hannes.core.by_value import ByValue
from hannes.core.effect import Effect
from hannes.core.errors import BadInput, ComputationFailed, nearest
from hannes.simulation.compiler.assemble import Compiled
from hannes.simulation.compiler.grasp_loop import LONGEST
from hannes.simulation.compiler.workspace import RUN
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.integrate import tolerances
from hannes.simulation.rodas.step import WORK
from hannes.simulation.rodas.whole_tick import TICK_KEPT
from hannes.simulation.simulate import check_tolerance

ROUNDING = 1e-9  # s between a tick and its sample
HISTORY = 256  # ticks of set points that a delayed command can still read


class Stepper(ByValue):
    """A hand on its way, tick by tick; `time` [s] is that of the next tick.

    Can be copied (`copy.copy`, `copy.deepcopy`) and pickled; copies go their own ways.
    """

    def __init__(
        self,
        hand: Hand,
        experiment: Experiment,
        rtol: float = 1e-4,
        effects: tuple[Effect, ...] | None = None,
    ) -> None:
        check_tolerance(rtol)
        self.hand, self.experiment, self.rtol, self.effects = hand, experiment, rtol, effects
        posed = hand.with_values(experiment.overrides())
        compiled = posed.compiled(effects)
        self._p = posed.vector(experiment.shape, effects)
        self._p[compiled.parameters["controller_sampled"]] = 1.0
        self._rest = posed.rest(compiled)
        self._build(compiled)
        self._y, self._memory, self._tick = self._rest.copy(), np.zeros(MEMORY), 0
        self._knots, self._times = experiment.reference.knots, experiment.times
        self._own: np.ndarray | None = None  # set points so far, where they do not come from there
        self._past: list[tuple[np.ndarray, np.ndarray]] = []  # dense output of ticks gone by

    @property
    def period(self) -> float:
        """Time between two ticks [s]."""
        return float(self._p[self._compiled.parameters["controller_period"]][0])

    @property
    def time(self) -> float:
        """Time of the next tick [s]."""
        return self._tick * self.period

    def state(self) -> dict[str, Any]:
        """Values of all states by name [SI units], at the next tick."""
        layout = self._compiled.states
        return {slot.name: self._y[layout[slot.name]].copy() for slot in layout.slots}

    def value(self, name: str) -> float:
        """Value of a parameter by its name in the compiled layout [SI]."""
        return float(self._p[self._place(name)][0])

    def set_value(self, name: str, value: float) -> None:
        """Change a parameter from the next tick on, by its name in the compiled layout [SI]."""
        self._p[self._place(name)] = value
        self._clock[TICK_KEPT] = 0.0

    def set_state(self, name: str, value: Any) -> None:
        """Put a state where a measurement has it, by its name in `state()` [SI units]."""
        if name not in self._compiled.states:
            known = [slot.name for slot in self._compiled.states.slots]
            raise BadInput(f'no state "{name}"{nearest(name, known)}')
        self._y[self._compiled.states[name]] = value
        self._clock[TICK_KEPT] = 0.0

    def _place(self, name: str) -> slice:
        if name not in self._compiled.parameters:
            known = [slot.name for slot in self._compiled.parameters.slots]
            raise BadInput(f'no compiled parameter "{name}"{nearest(name, known)}')
        return self._compiled.parameters[name]

    def step(self, reference: float | None = None) -> dict[str, Any]:
        """Let the firmware read, decide and drive until its next tick.

        `reference` [rad at the output shaft], None for that of the experiment. Returns all outputs
        by name [SI units], as they are at this tick once the firmware has set its duty. Raises
        ComputationFailed where the solver gives up.
        """
        now, fast, given = self.time, self._compiled.fast, self._given(reference)
        fast.tick(now, self._read(), self._p, given, self._memory)
        sampled = self._sample_time(now)
        row = self._integrate(now, (self._tick + 1) * self.period, given, sampled)
        self._tick += 1
        return self._outputs(sampled, row, given)

    def _given(self, reference: float | None) -> np.ndarray:
        """Knots of the reference (2, n): the experiment's, or the set points so far."""
        if reference is None and self._own is None:
            return self._knots
        if self._own is None:
            before = self.time - self.period * np.arange(HISTORY, 0, -1)
            self._own = np.vstack([before, np.full(HISTORY, float(reference or 0.0))])
        wanted = self._own[1, -1] if reference is None else float(reference)
        if not np.isfinite(wanted):
            raise BadInput(f"reference = {wanted}: expected a finite angle [rad]")
        self._own[:, :-1] = self._own[:, 1:]
        self._own[:, -1] = self.time, wanted
        return self._own

    def _read(self) -> np.ndarray:
        """The state that the firmware reads at this tick: an older one where readings are late."""
        age = self._memory[READING_AGE]
        if age <= 0.0:
            return self._y
        moment = self.time - age
        if moment <= 0.0 or not self._past:
            return self._rest
        for ends, pieces in self._past:
            if moment <= ends[-1]:
                row = np.zeros((1, self._y.size))
                self._compiled.fast.look_up(np.array([moment]), ends, pieces, row)
                return row[0]
        return self._y

    def _sample_time(self, now: float) -> float:
        """Time of this tick's sample [s]: the experiment's own, which rounding may set apart."""
        if self._tick < self._times.size and abs(self._times[self._tick] - now) < ROUNDING:
            return float(self._times[self._tick])
        return now

    def _outputs(self, now: float, state: np.ndarray, knots: np.ndarray) -> dict[str, Any]:
        compiled = self._compiled
        rows = compiled.observed.observe(
            np.array([now]), state, self._p, knots, self._memory[np.newaxis]
        )
        return compiled.outputs.named(rows[0])

    def _integrate(self, start: float, end: float, knots: np.ndarray, sampled: float) -> np.ndarray:
        """From one tick to the next, the duty held; returns the state (1, n) when it is sampled."""
        row = self._y[np.newaxis].copy()
        clock, counts = self._clock, self._counts
        clock[:TICK_KEPT] = start, end - start, end, LONGEST, 1.0
        counts[:] = 0
        bounds = np.array([end])
        keep = self._memory[READING_AGE] > 0.0
        while clock[0] != end:
            taken = self._compiled.fast.ticks_on(
                (self._room, self._p, knots, self._memory), self._y, self.rtol, self._atol,
                clock, counts, bounds, self._ends, self._pieces, self._work,
            )  # fmt: skip
            if counts[4] != 0:
                raise ComputationFailed(f"the solver gave up at {clock[0]:g} s; try a smaller rtol")
            if self._ends[0] == start:
                self._compiled.fast.look_up(
                    np.array([sampled]), self._ends[: taken + 1], self._pieces, row
                )
            if keep:
                self._past.append(
                    (self._ends[: taken + 1].copy(), self._pieces[: taken + 1].copy())
                )
        if keep:
            oldest = end - self._memory[READING_AGE] - self.period
            self._past = [each for each in self._past if each[0][-1] >= oldest]
        return row

    def _build(self, compiled: Compiled) -> None:
        """What does not travel with a pickle: machine code and workspace."""
        size = compiled.states.size
        self._compiled, self._atol = compiled, tolerances(compiled, self.rtol)
        self._ends, self._pieces = np.zeros(RUN + 1), np.zeros((RUN + 1, 3, size))
        self._work, self._clock = np.zeros((WORK, size)), np.zeros(6)
        self._counts, self._room = np.zeros(6, np.int64), compiled.workspace()

    def __getstate__(self) -> Mapping[str, Any]:
        built = ("_compiled", "_atol", "_ends", "_pieces", "_work", "_counts")
        return {name: value for name, value in vars(self).items() if name not in built}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        vars(self).update(state)
        posed = self.hand.with_values(self.experiment.overrides())
        self._build(posed.compiled(self.effects))
        self._clock, self._room = state["_clock"], state["_room"]

    def compared(self) -> tuple[Any, ...]:
        """What counts in ==: the machine, its command, and how far it has come."""
        kept = ("_clock", "_room")  # what the solver kept of the tick before
        return ({name: value for name, value in self.__getstate__().items() if name not in kept},)

    def __repr__(self) -> str:
        return f"Stepper({self.hand!r}, at {self.time:g} s)"

    def __copy__(self) -> Self:
        from copy import deepcopy

        return deepcopy(self)


def start(hand: Hand, experiment: Experiment, *, rtol: float = 1e-4) -> Stepper:
    """Return a Stepper at rest: `hand` under `experiment`, whose controller is sampled.

    Raises BadInput for a bad tolerance or value.
    """
    return Stepper(hand, experiment, rtol)
