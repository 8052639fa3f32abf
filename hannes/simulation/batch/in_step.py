"""Grasps near another one by its steps, several at once in the lanes of vector registers.

Where a step is too long for a grasp, that one goes its way to the step's end alone, by the loop of
single grasps. Its numbers are the same to the bit: what goes side by side only makes them quick.
"""

import time
from collections.abc import Sequence

import numpy as np

from hannes.control.firmware_memory import MEMORY
from hannes.simulation.batch.lanes import (
    FULL,
    TURN,
    Lanes,
    begin,
    in_order,
    kernels,
    one_by_one,
)
from hannes.simulation.compiled_call import Plan, Ran
from hannes.simulation.compiler.grasp_loop import PATH
from hannes.simulation.compiler.lanes.kernels import Kernels, aligned
from hannes.simulation.rodas.coefficients import FRESH, STAGES

ASTRAY = 0.5  # steps taken alone in a group, over those of the path: others like it are quicker so
# Of a step by each method: evaluations, Jacobians, factorings.
COSTS = np.array([[1 + np.count_nonzero(FRESH[m, 1 : STAGES[m]]), 1, 1] for m in range(2)])


def run_alike(
    plan: Plan, vectors: np.ndarray, starts: np.ndarray, stop: np.ndarray | None = None
) -> Ran:
    """Run one grasp for each row of `vectors` from `starts`, all by the steps of the first one."""
    path, clock = np.zeros(PATH), time.perf_counter()
    stop = np.zeros(1, np.bool_) if stop is None else stop
    first = plan.run(vectors[:1], starts[:1], stop, path)
    followers = np.arange(1, vectors.shape[0])
    made = kernels(plan, followers.size, "in_step") if path[0] > 0.0 else None
    together = np.zeros(followers.size, np.bool_)
    if made is not None:
        switches = list(made.switches)
        together = (vectors[1:, switches] == vectors[0, switches]).all(axis=1)
    parts, alone = [(np.zeros(1, int), first)], followers[~together]
    if made is not None and together.any():
        lanes, rows = InStep(plan, made, path, stop), followers[together]
        while rows.size >= FULL * made.width and not lanes.astray:
            chosen, rows = rows[: made.width], rows[made.width :]
            parts.append((chosen, lanes.run(vectors[chosen], starts[chosen])))
        alone = np.concatenate((alone, rows))
    if alone.size:
        followed = path if path[0] > 0.0 else None  # where it failed, each takes its own steps
        parts.append((alone, one_by_one(plan, vectors[alone], starts[alone], stop, followed)))
    return in_order(parts, time.perf_counter() - clock)


class InStep(Lanes):
    """Groups one after the other, by the steps of `path`."""

    def __init__(self, plan: Plan, made: Kernels, path: np.ndarray, stop: np.ndarray) -> None:
        super().__init__(plan, made)
        self.path, self.stop = path, stop
        self.astray = False  # whether the last group mostly went its own ways
        self.places = np.concatenate(([0.0], path[1 : int(path[0]) + 1]))
        self.until = plan.times.searchsorted(self.places, "left")  # samples before each of them
        self.until[-1] = plan.times.size
        samples, states, width = plan.times.size, plan.atol.size, made.width
        self.rows = aligned(samples * states * width).reshape(samples, states, width)
        self.kept = aligned(samples * plan.columns.size * width).reshape(samples, -1, width)
        self.alone = (
            np.zeros((samples, states)), np.zeros((samples, MEMORY)),
            np.zeros((1, plan.columns.size, samples)),
        )  # fmt: skip

    def run(self, vectors: np.ndarray, starts: np.ndarray) -> Ran:
        """Up to `width` grasps."""
        size, at = vectors.shape[0], self.at
        self.fill(vectors, starts)
        counts, apart = np.zeros((size, 6), np.int64), list[tuple[int, slice, np.ndarray]]()
        place, count = 0, self.places.size - 1
        while place < count and at["alive"].any() and not self.stop[0]:
            before, place = place, self._steps(place)
            alive = at["alive"][0, :size] > 0.0
            missed = alive & ~(at["error"][0, :size] < 1.0)
            taken = alive * (place - before) - missed
            counts[:, :3] += taken[:, np.newaxis] * COSTS[self.method]
            for lane in np.flatnonzero(missed).tolist():
                apart.append(self._alone(lane, place - 1, vectors[lane : lane + 1], counts))
        self.astray = len(apart) > ASTRAY * count
        return self._sampled(size, counts, apart)

    def _steps(self, place: int) -> int:
        """Take steps of the path; how many of them are taken now."""
        plan, until = self.plan, int(self.until[place])
        taken: int = self.made.steps(
            begin(self.at), self.method, plan.rtol, plan.atol.ctypes.data,
            self.path.ctypes.data, place, min(place + TURN, self.places.size - 1),
            plan.times.ctypes.data, plan.times.size, until, self.rows.ctypes.data,
        )  # fmt: skip
        return taken

    def _alone(
        self, lane: int, step: int, vector: np.ndarray, counts: np.ndarray
    ) -> tuple[int, slice, np.ndarray]:
        """Take one grasp through one of the path's steps by itself; its samples."""
        plan, at, own = self.plan, self.at, counts[lane : lane + 1]
        begin, end = self.until[step : step + 2]
        y = np.ascontiguousarray(at["piece"][:1, :, lane])
        rows, memories, kept = self.alone
        plan.compiled.fast.grasps(
            vector, y, plan.knots, self.places[step + 1 : step + 2], np.zeros(1),
            plan.times[begin:end], plan.columns, plan.needed, plan.rtol, plan.atol, self.stop,
            self.path, step, rows, memories, kept, own,
        )  # fmt: skip
        at["state"][0, :, lane] = y[0]
        own[0, 5] += begin
        if own[0, 4]:
            self._end(lane)
        return lane, slice(begin, own[0, 5]), kept[0, :, : own[0, 5] - begin].copy()

    def _end(self, lane: int) -> None:
        """A lane whose grasp failed goes on as another one, which nobody looks at."""
        alive = self.at["alive"][0]
        alive[lane] = 0.0
        other = int(np.argmax(alive))
        for name in ("p", "p_over", "state"):
            self.at[name][..., lane] = self.at[name][..., other]

    def _sampled(
        self, size: int, counts: np.ndarray, apart: Sequence[tuple[int, slice, np.ndarray]]
    ) -> Ran:
        """What was asked for of each grasp."""
        last = self.plan.times.searchsorted(self.places[-1], "left")
        self.rows[last:] = self.at["state"][0]
        self.made.in_samples(
            begin(self.at), self.plan.times.ctypes.data, self.rows.ctypes.data,
            self.kept.ctypes.data, 0, self.plan.times.size,
        )  # fmt: skip
        kept = np.ascontiguousarray(self.kept.T[:size])
        for lane, place, own in apart:
            kept[lane, :, place] = own
        counts[self.at["alive"][0, :size] > 0.0, 5] = self.plan.times.size
        return Ran(self.alone[0], self.alone[1], kept, counts, 0.0)
