"""Many grasps on all cores, streamed in order."""

import operator
import os
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.simulation.batch.chunks import Asked, Part, Table, paired
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import check_tolerance
from hannes.simulation.trajectory import Grasp

AHEAD = 2  # windows for each worker that are under way or wait to be fetched


def simulate_many(
    hands: Hand | Iterable[tuple[Hand, Experiment]],
    experiment: Experiment | None = None,
    values: Mapping[str, ArrayLike] | None = None,
    *,
    channels: Sequence[str] = ("position", "current", "force"),
    sampling: float | None = None,
    rtol: float = 1e-4,
    effects: tuple[Effect, ...] | None = None,
    workers: int | None = None,
    progress: bool = True,
) -> Iterator[Grasp]:
    """Simulate many grasps on all cores and yield each as a Grasp, in order.

    Either one hand in one experiment with parameters in columns: SI values by full name, shape
    (n,) or a single number, which take the place of those of hand and experiment:

        stiffness = np.linspace(800.0, 8000.0, 1000)  # N/m
        for grasp in simulate_many(hand, experiment, {"object.stiffness": stiffness}):
            peaks.append(grasp["force"].max())

    or pairs of hand and experiment, read as they are needed, so that a generator will do:

        for grasp in simulate_many((hand, each) for each in experiments):
            peaks.append(grasp["force"].max())

    `channels` are names of outputs or states, `sampling` [Hz] replaces that of the experiments.
    `rtol` and `effects` are those of `simulate`; results equal its own to the last bit for any
    number of `workers` (default: all cores). Only some grasps of each worker are in memory at a
    time. A grasp that fails has another outcome and stops nothing. `progress` shows a bar on
    standard error after two seconds. Raises BadInput for a bad name, value, tolerance or number
    of workers.
    """
    check_tolerance(rtol)
    workers = _cores() if workers is None else workers
    if workers < 1:
        raise BadInput(f"workers = {workers}: expected 1 or more")
    asked = Asked(tuple(channels), sampling, rtol, effects, 2 * AHEAD * workers)
    if isinstance(hands, Hand):
        if experiment is None:
            raise BadInput("expected an experiment beside the hand, or pairs of both")
        table = Table.of(hands, experiment, values or {})
        return _streamed(table.windows(asked), table.count, workers, progress)
    if experiment is not None or values is not None:
        raise BadInput("expected pairs of hand and experiment alone, or one hand beside the rest")
    count = operator.length_hint(hands)
    return _streamed(paired(iter(hands), count, asked), count, workers, progress)


def simulate_alike(
    hand: Hand,
    experiment: Experiment,
    values: Mapping[str, ArrayLike],
    *,
    channels: Sequence[str],
    rtol: float,
    effects: tuple[Effect, ...] | None = None,
) -> list[Grasp]:
    """Many grasps near the first one, all by its steps, always with the continuous controller.

    What grasps differ by is then smooth at a wide tolerance too: no solver chose other steps for
    each (internal differentiation, Bock 1981). A step too long for a grasp is cut; one that takes
    20 times as many as the first has another outcome, as one that fails. Where the first one
    itself fails, each takes its own steps. Several go side by side in the lanes of vector
    registers; bits do not depend on which. `values`: columns as of `simulate_many`. Raises BadInput
    as that does.
    """
    check_tolerance(rtol)
    workers, smooth = _cores(), replace(experiment, controller="continuous")
    table = Table.of(hand, smooth, values)
    windows = table.alike(Asked(tuple(channels), None, rtol, effects, 1), workers)
    grasps = list(_streamed(windows, table.count, workers, False))
    return [grasp for k, grasp in enumerate(grasps) if grasp.number or not k]


def _cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _streamed(
    windows: Iterator[list[Part]], count: int, workers: int, progress: bool
) -> Iterator[Grasp]:
    """Grasps in order, a few windows being run ahead; ends its threads whatever happens."""
    from hannes.core.io.progress import progress_bar

    stop, pool = np.zeros(1, np.bool_), ThreadPoolExecutor(workers)
    ahead: deque[Future[list[Grasp]]] = deque()
    shown = {"delay": 2.0, "leave": False, "disable": not progress}
    bar = progress_bar(total=count or None, desc="simulating", unit=" grasps", **shown)
    try:
        for window in windows:
            ahead.append(pool.submit(_run, window, stop))
            if len(ahead) > AHEAD * workers:
                yield from _fetched(ahead.popleft(), bar)
        while ahead:
            yield from _fetched(ahead.popleft(), bar)
    finally:
        stop[0] = True
        pool.shutdown(cancel_futures=True)
        bar.close()


def _run(window: list[Part], stop: np.ndarray) -> list[Grasp]:
    grasps = [grasp for part in window for grasp in part.run(stop)]
    return sorted(grasps, key=lambda grasp: grasp.number)


def _fetched(running: Future[list[Grasp]], bar: Any) -> Iterator[Grasp]:
    grasps = running.result()
    bar.update(len(grasps))
    yield from grasps
