"""Grasps each by its own steps, several at once in the lanes of vector registers.

Their numbers are those of the loop of single grasps, to the bit. A grasp that fails, or needs far
more steps than what it shares the registers with, is left to that loop.
"""

import threading
import time

import numpy as np

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
from hannes.simulation.compiler.grasp_loop import LONGEST, PATH
from hannes.simulation.compiler.lanes.kernels import Kernels, aligned

FEW = 0.25  # of the lanes: fewer that go on alone are left soon
LEFT = 1.25  # turns that they may take, over those after which so few were left
IDLE = 0.6  # part of all attempts that were a grasp's own, below which single grasps are quicker

_thread = threading.local()


def run_many(plan: Plan, vectors: np.ndarray, starts: np.ndarray, stop: np.ndarray) -> Ran:
    """Run one grasp for each row of `vectors` from `starts`."""
    clock, count = time.perf_counter(), vectors.shape[0]
    made = kernels(plan, count, "own_steps")
    if made is None or count < FULL * made.width:
        return one_by_one(plan, vectors, starts, stop)
    lanes, parts, alone = _at_hand(plan, made, stop), [], np.ones(count, np.bool_)
    for rows in groups(vectors, made.switches, made.width):
        if rows.size >= FULL * made.width and not lanes.idle:
            ran = lanes.run(vectors[rows], starts[rows])
            parts.append((rows[lanes.ended], ran))
            alone[rows[lanes.ended]] = False
    if alone.any():
        rows = np.flatnonzero(alone)
        parts.append((rows, one_by_one(plan, vectors[rows], starts[rows], stop)))
    return in_order(parts, time.perf_counter() - clock)


def _at_hand(plan: Plan, made: Kernels, stop: np.ndarray) -> "OwnSteps":
    """Room that this thread had for the window before, where that was of the same kind."""
    found: OwnSteps | None = getattr(_thread, "lanes", None)
    if found is None or found.plan is not plan or found.made is not made:
        found = _thread.lanes = OwnSteps(plan, made)
    found.stop, found.idle = stop, False
    return found


def groups(vectors: np.ndarray, switches: tuple[int, ...], width: int) -> list[np.ndarray]:
    """Rows that go side by side: with the same `switches`, and as alike as can be.

    They are ordered by what takes the fewest values, as whether there is an object; then by others.
    """
    stages = vectors[:, list(switches)]
    varying = vectors[:, np.ptp(vectors, axis=0) > 0.0]
    kinds = [np.unique(column).size for column in varying.T]
    first = varying[:, np.argsort(kinds, kind="stable")]
    order = np.lexsort(np.hstack((np.ones((len(vectors), 1)), first[:, ::-1], stages)).T)
    parted = np.diff(stages[order], axis=0).any(axis=1)
    runs = np.split(order, np.flatnonzero(parted) + 1)
    return [run[k : k + width] for run in runs for k in range(0, run.size, width)]


class OwnSteps(Lanes):
    """Groups one after the other; which of the last one's grasps came to their end."""

    idle = False  # whether the last group's lanes mostly waited for others
    ended: np.ndarray
    stop: np.ndarray

    def __init__(self, plan: Plan, made: Kernels) -> None:
        super().__init__(plan, made)
        width, samples, states = made.width, plan.times.size, plan.atol.size
        rows, columns = -(-samples // width), plan.columns.size
        self.moments = aligned(rows * width)
        self.moments[:] = np.inf
        self.moments[:samples] = plan.times
        # Samples of a grasp stand side by side, as many as there are lanes, in rows.
        self.rows = aligned(width * rows * states * width).reshape(width, rows, states, width)
        self.kept = aligned(rows * columns * width).reshape(rows, columns, width)
        self.one = self.workspace(alone=True)
        self.fed = [each.ctypes.data for each in self.rows]
        moments, bounds = self.moments.ctypes.data, plan.bounds
        self.asked = (
            begin(self.at), self.method, plan.rtol, plan.atol.ctypes.data, bounds.ctypes.data,
            bounds.size, moments, rows,
        )  # fmt: skip
        self.looked = begin(self.one), moments, self.kept.ctypes.data

    def run(self, vectors: np.ndarray, starts: np.ndarray) -> Ran:
        """Up to `width` grasps."""
        size, at, plan = vectors.shape[0], self.at, self.plan
        self.fill(vectors, starts)
        for name in ("clock", "counts", "tries", "place", "failed"):
            at[name][:] = 0.0
        at["clock"][2:5] = np.array([[plan.bounds[0]], [LONGEST], [1.0]])
        turns = self._turns()
        self.ended = np.flatnonzero((at["alive"][0, :size] + at["failed"][0, :size]) == 0.0)
        counts = np.zeros((self.ended.size, 6), np.int64)
        counts[:, :3] = at["counts"][:3, self.ended].T
        counts[:, 5] = plan.times.size
        self.idle = bool(counts[:, 2].sum() < IDLE * size * turns)
        kept = np.empty((self.ended.size, plan.columns.size, plan.times.size))
        for each, lane in zip(kept, self.ended.tolist(), strict=True):
            self._sampled(lane, each)
        return Ran(self.rows, self.rows, kept, counts, 0.0)

    def _turns(self) -> int:
        """Take turns until all have ended, or what is left is to go on alone; how many."""
        turns, most, alive = 0, PATH, self.at["alive"][0]
        while alive.any() and turns < most and not self.stop[0]:
            turns += self.made.steps(*self.asked, min(TURN, most - turns), self.fed[0])
            if most == PATH and np.count_nonzero(alive) <= FEW * self.made.width:
                most = int(LEFT * turns)
        return turns

    def _sampled(self, lane: int, kept: np.ndarray) -> None:
        """What was asked for of a grasp, samples beyond its last step being of its end."""
        times, rows, one = self.plan.times, self.rows[lane], self.one
        for k in range(times.searchsorted(self.plan.bounds[-1], "left"), times.size):
            rows[k // self.made.width, :, k % self.made.width] = self.at["state"][0, :, lane]
        for name in ("p", "p_over"):
            one[name][:] = self.at[name][:, lane]
        room, moments, found = self.looked
        self.made.in_samples(room, moments, self.fed[lane], found, 0, rows.shape[0])
        kept[:] = self.kept.transpose(1, 0, 2).reshape(kept.shape[0], -1)[:, : times.size]
