"""A batch in windows: runs of grasps, in order, each cut into parts that one compiled call does."""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.core.parameter import Parameter
from hannes.simulation.batch.in_step import run_alike
from hannes.simulation.batch.own_steps import run_many
from hannes.simulation.compiled_call import Plan, ended
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.trajectory import Grasp

MOST = 32  # grasps of one window: long against its overhead, short against a batch
FOLLOWERS = 4  # of a run that is made once in each window, at least
BYTES = 2**24  # that the results of one window may take

Effects = tuple[Effect, ...]


@dataclass(frozen=True)
class Part:
    """Grasps that one compiled call does."""

    plan: Plan
    titles: Sequence[str]
    numbers: Sequence[int]
    vectors: np.ndarray
    starts: np.ndarray
    alike: bool = False

    def run(self, stop: np.ndarray) -> list[Grasp]:
        """Run them; where `stop` is set meanwhile, what comes back is of no use."""
        given = self.plan, self.vectors, self.starts, stop
        ran = run_alike(*given) if self.alike else run_many(*given)
        share = ran.seconds / len(self.numbers)
        rows = zip(self.numbers, self.titles, ran.counts, ran.kept, self.vectors, strict=True)
        return [
            Grasp(
                number,
                title,
                self.plan.times[: counts[5]],
                self.plan.named(kept[:, : counts[5]].copy()),  # a view would hold all of them
                *ended(counts),
                self.plan.cost(counts, p, share),
            )
            for number, title, counts, kept, p in rows
        ]


@dataclass(frozen=True)
class Asked:
    """What is asked of every grasp, and how many windows a batch should have at least."""

    channels: tuple[str, ...]
    sampling: float | None
    rtol: float
    effects: Effects | None
    fewest: int

    def plan(self, hand: Hand, effects: Effects, experiment: Experiment) -> Plan:
        """Plan an experiment, compiled: threads that compile could not be interrupted."""
        if self.sampling is not None:
            experiment = replace(experiment, sampling=self.sampling)
        return Plan.of(hand.compiled(effects), experiment, self.rtol, self.channels).make_ready()

    def size(self, plan: Plan, count: int) -> int:
        """Grasps in a window, out of `count`, or of an unknown number (0)."""
        fitting = BYTES // max(1, 8 * plan.columns.size * plan.times.size)
        shared = -(-count // self.fewest) if count else MOST
        return max(1, min(MOST, fitting, shared))


def _numbers(name: str, value: ArrayLike) -> np.ndarray:
    try:
        return np.asarray(value, float)
    except (TypeError, ValueError):
        raise BadInput(f"{name} = {value!r:.60}: expected numbers in SI units") from None


@dataclass(frozen=True)
class Table:
    """A hand in an experiment, whose values it has, with parameters in columns of `count` rows."""

    hand: Hand
    experiment: Experiment
    columns: Mapping[str, np.ndarray]
    count: int

    @staticmethod
    def of(hand: Hand, experiment: Experiment, values: Mapping[str, ArrayLike]) -> "Table":
        """Check `values` and spread them to columns of one length."""
        posed = hand.with_values(experiment.overrides())
        given = {name: _numbers(name, value) for name, value in values.items()}
        if "controller.sampled" in given:
            raise BadInput('controller.sampled is no column: give controller = "sampled" instead')
        _check([posed.parameters.require(name) for name in given], list(given.values()))
        sizes = {column.size for column in given.values() if column.ndim}
        if len(sizes) > 1 or any(column.ndim > 1 for column in given.values()):
            shapes = ", ".join(f"{name} {column.shape}" for name, column in given.items())
            raise BadInput(f"expected single numbers and columns of one length, got {shapes}")
        count = sizes.pop() if sizes else 1
        columns = {
            name: column if column.ndim else np.broadcast_to(column, count)
            for name, column in given.items()
        }
        return Table(posed, experiment, columns, count)

    def windows(self, asked: Asked) -> Iterator[list[Part]]:
        """Row after row, those of a window apart by the effects that are present in them."""
        sets, kinds = self._kinds(asked.effects)
        plans = [asked.plan(self.hand, effects, self.experiment) for effects in sets]
        size = asked.size(plans[0], self.count) if plans else 1
        for start in range(0, self.count, size):
            kind = kinds[start : start + size]
            yield [
                self._part(plans[k], sets[k], start + np.flatnonzero(kind == k))
                for k in np.unique(kind)
            ]

    def alike(self, asked: Asked, windows: int) -> Iterator[list[Part]]:
        """The first row at the head of each window, whose steps all rows take, and the others."""
        effects = self.hand.effects if asked.effects is None else asked.effects
        plan = asked.plan(self.hand, effects, self.experiment)
        if not self.count:
            return
        parts = max(1, min(windows, (self.count - 1) // FOLLOWERS))
        for rows in np.array_split(np.arange(1, self.count), parts):
            part = self._part(plan, effects, np.concatenate(([0], rows)))
            yield [replace(part, alike=True)]

    def _kinds(self, fixed: Effects | None) -> tuple[list[Effects], np.ndarray]:
        """Sets of effects that are compiled in, and which of them each row has."""
        if fixed is not None:
            return [fixed], np.zeros(self.count, int)
        code = np.zeros(self.count, int)
        for n, effect in enumerate(self.hand.effects):
            for each in effect.amplitudes:
                name = effect.full_name(each.name)
                value = self.columns.get(name, self.hand.parameters[name])
                code |= (value != each.off) * np.int64(1 << n)
        codes, kinds = np.unique(code, return_inverse=True)
        named = list(enumerate(self.hand.effects))
        return [tuple(e for n, e in named if int(c) >> n & 1) for c in codes], kinds

    def _part(self, plan: Plan, effects: Effects, rows: np.ndarray) -> Part:
        columns = {name: column[rows] for name, column in self.columns.items()}
        vectors = self.hand.vectors(self.experiment.shape, rows.size, columns, effects)
        starts = self.hand.rests(plan.compiled, vectors)
        return Part(plan, [self.experiment.title] * rows.size, rows.tolist(), vectors, starts)


def _check(declared: Sequence[Parameter], columns: Sequence[np.ndarray]) -> None:
    """Raise BadInput for the first value that is not inside the bounds."""
    numbers = np.concatenate([column.ravel() for column in columns]) if columns else np.zeros(0)
    bounds = np.array([each.bounds for each in declared]).reshape(-1, 2)
    low, high = np.repeat(bounds, [column.size for column in columns], axis=0).T
    if ((numbers >= low) & (numbers <= high)).all():
        return
    for each, column in zip(declared, columns, strict=True):
        for value in column.ravel().tolist():
            each.check(value)


def paired(
    pairs: Iterator[tuple[Hand, Experiment]], count: int, asked: Asked
) -> Iterator[list[Part]]:
    """Pair after pair, those of a window apart by model and by course of the experiment."""
    start, size = 0, 1
    while chosen := list(islice(pairs, size)):
        plans: dict[Hashable, Plan] = {}
        rows: dict[Hashable, list[tuple[str, int, np.ndarray, np.ndarray]]] = {}
        for number, pair in enumerate(chosen, start):
            hand, experiment = _pair(pair, number)
            effects = hand.present_effects() if asked.effects is None else asked.effects
            kind = (effects, *_course(experiment))
            if kind not in plans:
                plans[kind] = asked.plan(hand, effects, experiment)
            vector = hand.vector(experiment.shape, effects)
            row = (experiment.title, number, vector, hand.rest(plans[kind].compiled))
            rows.setdefault(kind, []).append(row)
        yield [_stacked(plan, rows[kind]) for kind, plan in plans.items()]
        start += len(chosen)
        size = min(asked.size(plan, count) for plan in plans.values())


def _pair(pair: Any, number: int) -> tuple[Hand, Experiment]:
    """Hand with the experiment's values, and the experiment."""
    match pair:
        case (Hand() as hand, Experiment() as experiment):
            return hand.with_values(experiment.overrides()), experiment
    raise BadInput(f"pair {number}: expected a Hand and an Experiment, got {pair!r}")


def _course(experiment: Experiment) -> tuple[Hashable, ...]:
    """What experiments have in common that can share a compiled call."""
    reference = experiment.reference
    times = (experiment.duration, experiment.sampling, experiment.controller)
    return (*times, reference.kinked, reference.knots.tobytes())


def _stacked(plan: Plan, rows: list[tuple[str, int, np.ndarray, np.ndarray]]) -> Part:
    titles, numbers, vectors, starts = zip(*rows, strict=True)
    return Part(plan, titles, numbers, np.array(vectors), np.array(starts))
