"""Simulations of every group at many points of the parameter space at once, as vectors."""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import Any

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import ComputationFailed
from hannes.core.recording.white_noise import roughness
from hannes.identification.diagnosis.known_vectors import KnownVectors
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.repeat_groups import Channels, Group
from hannes.identification.diagnosis.sampling_error import DiscretisationError, SamplingCorrection
from hannes.identification.diagnosis.tuning import NOISE, SEARCH
from hannes.identification.diagnosis.work_bound import Work, as_single, ordinary_time
from hannes.plants.part_fault import compiled_effects
from hannes.plants.protocol import Plant, with_parts

NOWHERE = (
    "the baseline cannot be simulated under a recording's reference; set `base` to a nearer machine"
)
NOTHING: Mapping[str, np.ndarray] = {}
NO_PART: Mapping[str, float] = {}
Unrounded = Callable[[int], Mapping[str, np.ndarray]]  # of a Plant, see there


class Model:
    """A plant, all runs it shall explain, and the effects on trial.

    Simulations are quick ones. What the firmware's sampling and rounding add is computed apart
    (`discretisation_errors`) and changes little. `small` is the model without effects, `whole`
    the one with all candidate effects, so that one compilation serves them all. `bandwidth` [Hz] is
    that of the sensors' noise, 0 where it is white, None where the plant's own holds. `parts_at`
    says by how much like parts of the machine are off, in standard deviations, by name.
    """

    def __init__(
        self,
        plant: Plant,
        groups: Sequence[Group],
        space: ParameterSpace,
        effects: Sequence[Effect],
        work: Work | None = None,
        bandwidth: float | None = None,
    ) -> None:
        self.groups, self.space = list(groups), space
        self.small, self.whole = plant, plant.with_effects(*compiled_effects(tuple(effects)))
        self._stated, self.parts_at = (self.small, self.whole), NO_PART
        self._corrections: dict[int, dict[int, SamplingCorrection]] = {}  # group, place
        self.work = work or Work()  # of this model and all made of it
        self._held = False  # whether effects are a fixed part of the machine
        self._known, self.bandwidth = KnownVectors(), bandwidth

    def with_sampling_correction(self, x: np.ndarray, effects: Sequence[str]) -> "Model":
        """The same, quick simulations corrected for the controller's sampling near x.

        A lag of half a sampling interval acts differently in a sampled and in a continuous loop;
        one of many intervals acts the same. So the difference is simulated at a few small sizes,
        and about the size at x. Only effects on what the firmware reads or writes are corrected:
        on others sampling does less than these differences resolve. The signature of an effect
        with a shape changes with it, so such effects are not corrected.
        """
        made = copy(self)
        made._corrections = {key: dict(each) for key, each in self._corrections.items()}
        places = self.space.of(*(name for name in effects if self.in_loop(name)))
        unrounded: Unrounded | None = getattr(self.small, "unrounded", None)
        if unrounded is None or not places.size:
            return made
        for group in self.groups:
            found = self._sampling_corrections(group, x, places, unrounded)
            made._corrections.setdefault(id(group), {}).update(found)
        return made

    def of(self, groups: Sequence[Group], numbers: Sequence[int]) -> "Model":
        """The same for other runs under the commands of the groups of these numbers."""
        made = copy(self)
        made.groups, made._corrections = list(groups), {}
        pairs = zip(groups, (self.groups[k] for k in numbers), strict=True)
        made._corrections = {
            id(new): self._corrections[id(old)]
            for new, old in pairs
            if id(old) in self._corrections
        }
        return made

    def held(self, groups: Sequence[Group]) -> "Model":
        """The same for its runs in other bins, with the effects as a fixed part of the machine."""
        made = copy(self)
        made.groups, made.small, made._corrections, made._held = list(groups), self.whole, {}, True
        made._stated = self._stated[1], self._stated[1]
        return made

    def with_parts_at(self, deviations: Mapping[str, float]) -> "Model":
        """The same with like parts as far off for themselves, in standard deviations, by name."""
        made, share = copy(self), self.space.settings.scatter_apart
        relative = {name: share * deviation for name, deviation in deviations.items()}
        made.small, made.whole = (with_parts(each, relative) for each in self._stated)
        made.space, made._known = self.space.simulating(made.whole.parameters), KnownVectors()
        made.parts_at = dict(deviations)
        return made

    def as_machine(self) -> "Model":
        """The same for its runs, with the effects as a fixed part of the machine."""
        made = self.held(self.groups)
        made._corrections = self._corrections
        return made

    def in_loop(self, name: str) -> bool:
        """Whether an effect acts on what the firmware reads or writes, and has no shape."""
        effect, firmware = self.space.effects[name], getattr(self.small, "firmware", ())
        written = {channel for term in effect.terms for channel in term.writes}
        return bool(written & set(firmware)) and len(effect.amplitudes) == len(effect.parameters)

    def _sampling_corrections(
        self, group: Group, x: np.ndarray, places: np.ndarray, unrounded: Unrounded
    ) -> dict[int, SamplingCorrection]:
        """Change by sampling of a group's bin means, by place, at some sizes of each effect."""
        tried = [(int(place), size) for place in places for size in self._sizes(x, place)]
        rows = np.repeat(x[np.newaxis], 1 + len(tried), axis=0)
        rows[:, places] = 0.0
        for row, (place, size) in zip(rows[1:], tried, strict=True):
            row[place] = size
        runs = self.simulated(group, rows, True, True, unrounded(len(rows)))
        apart = self._vectors(group, runs) - self._vectors(group, self.simulated(group, rows, True))
        return {
            int(place): SamplingCorrection.of(int(place), tried, apart - apart[0])
            for place in places
        }

    def _sizes(self, x: np.ndarray, place: int) -> np.ndarray:
        """Sizes of an effect, other than none, at which sampling is simulated."""
        low, high = self.space.low[place], self.space.high[place]
        there = (float(x[place]) * share for share in NOISE.correction_shares)
        sizes = np.unique(
            [*NOISE.correction_sizes, *(-size for size in NOISE.correction_sizes), *there]
        )
        return sizes[(low <= sizes) & (sizes <= high) & (sizes != 0.0)]

    def simulated(
        self,
        group: Group,
        rows: np.ndarray,
        effects: bool,
        exact: bool = False,
        further: Mapping[str, np.ndarray] = NOTHING,
    ) -> list[Channels | None]:
        """Channels of a group for rows of x, shape (m, size); None where a run fails.

        further: columns by full name [SI], shape (m,) each, beside those of x
        """
        effects = effects or self._held
        counted = self._count(group, len(rows), exact)
        plant = self.whole if effects else self.small
        columns = self.space.columns(group, rows, effects) | dict(further)
        many = getattr(plant, "many", None)
        if many is not None:
            made = many(columns, group.recording, group.names, exact)
            return self.work.taken(made, counted)
        singly = [
            {name: float(column[k]) for name, column in columns.items()} for k in range(len(rows))
        ]
        return [_alone(plant, values, group) for values in singly]

    def apart(
        self, group: Group, x: np.ndarray, share: float
    ) -> dict[str, tuple[Channels, Channels]]:
        """Like part -> changes of a group's channels with it off by a share, up and down, at x.

        {} where the plant has none. Raises ComputationFailed where no run nearby succeeds."""
        return self._of_parts("apart", group, x, share) or {}

    def together(
        self, group: Group, x: np.ndarray, share: float
    ) -> list[tuple[Channels, Channels]]:
        """The same with all like parts off at once, by some draws; [] where the plant has none."""
        return self._of_parts("together", group, x, share) or []

    def _of_parts(self, what: str, group: Group, x: np.ndarray, share: float) -> Any:
        simulated = getattr(self.small, what, None)
        if simulated is None:
            return None
        columns = self.space.columns(group, x[np.newaxis], self._held)
        values = {name: float(column[0]) for name, column in columns.items()}
        found = simulated(values, share, group.recording, group.names)
        self._count(group, as_single(1 + 2 * len(found)), False)
        return found

    def round_of_derivatives(self) -> float:
        """Time [s] that single runs for derivatives by all values of the machine would simulate."""
        return self.space.uncertain.size * sum(map(self._duration, self.groups))

    def _duration(self, group: Group) -> float:
        return ordinary_time(self.small, float(np.ptp(group.recording.time)))

    def _count(self, group: Group, runs: float, exact: bool) -> float:
        return self.work.add(runs, self._duration(group), exact)

    def vectors(
        self, group: Group, rows: np.ndarray, effects: bool, exact: bool = False
    ) -> np.ndarray:
        """Bin means for rows of x, shape (m, n); nan where a run fails."""
        effects = effects or self._held
        if exact:
            return self._vectors(group, self.simulated(group, rows, effects, exact))

        def made(fresh: np.ndarray) -> np.ndarray:
            return self._vectors(group, self.simulated(group, fresh, effects))

        found = self._known.of(group, effects, rows, made)
        return self._corrected(group, found, rows) if effects else found

    def changes(
        self,
        group: Group,
        x: np.ndarray,
        rows: np.ndarray,
        effects: bool,
        here: np.ndarray | None = None,
    ) -> np.ndarray:
        """Changes of bin means from x to rows, shape (m, n); nan where one fails.

        By runs that take the same solver steps, where the plant has them: the solver's errors then
        cancel. Other plants need not simulate x again where its vector is known (`here`, (n,)).
        """
        effects = effects or self._held
        plant, stacked = self.whole if effects else self.small, np.vstack([x, rows])
        same_steps = getattr(plant, "alike", None)
        if same_steps is None and here is not None:
            return self.vectors(group, rows, effects) - here
        if same_steps is None:
            made = self.vectors(group, stacked, effects)
        else:
            counted = self._count(group, as_single(len(stacked)), False)
            columns = self.space.columns(group, stacked, effects)
            runs = same_steps(columns, group.recording, group.names)
            made = self._vectors(group, self.work.taken(runs, counted, SEARCH.alike_weight))
            made = self._corrected(group, made, stacked) if effects else made
        return made[1:] - made[0]

    def _corrected(self, group: Group, vectors: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Vectors of quick simulations with the sampling corrections added."""
        for place, correction in self._corrections.get(id(group), {}).items():
            vectors = vectors + correction.at(rows[:, place])
        return vectors

    def _vectors(self, group: Group, runs: Sequence[Channels | None]) -> np.ndarray:
        found = np.full((len(runs), group.part.size), np.nan)
        for row, channels in zip(found, runs, strict=True):
            if channels is not None:
                row[:] = group.vector(channels)
        return found

    def discretisation_errors(
        self, x: np.ndarray, samples: int, seed: int
    ) -> "list[DiscretisationError]":
        """What the sampled controller adds to each group near x, and its variation between runs.

        Its rounding makes a pattern that the least change moves. Its sensor noise, where the plant
        simulates it (`noisy`), moves the machine.
        """
        rows = x + np.zeros((samples, x.size))
        known = self.space.uncertain
        drawn = np.random.default_rng([seed, 7]).standard_normal((samples, known.size))
        rows[:, known] += NOISE.contact_nudge * drawn
        return [self._discretisation_error(group, rows) for group in self.groups]

    def _noisy(self, group: Group, count: int) -> Mapping[str, np.ndarray]:
        """Columns by which each of `count` runs of a group has other noise of its sensors."""
        noisy = getattr(self.small, "noisy", None)
        if noisy is None:
            return NOTHING
        coloured = {} if self.bandwidth is None else {"bandwidth": self.bandwidth}
        found: Mapping[str, np.ndarray] = noisy(group.recording, count, **coloured)
        return found

    def _discretisation_error(self, group: Group, rows: np.ndarray) -> "DiscretisationError":
        further = self._noisy(group, len(rows))
        made = self.simulated(group, rows, False, exact=True, further=further)
        pairs = [
            (run, smooth)
            for run, smooth in zip(made, self.vectors(group, rows, False), strict=True)
            if run is not None and np.isfinite(smooth).all()
        ]
        if len(pairs) < NOISE.fewest_simulations:
            raise ComputationFailed(NOWHERE)
        difference = np.array([group.vector(run) - smooth for run, smooth in pairs])
        mean = difference.mean(axis=0)
        recorded = [{name: roughness(run[name]) for name in group.names} for run, _ in pairs]
        usual = {name: float(np.median([each[name] for each in recorded])) for name in group.names}
        deviations = (difference - mean) * np.sqrt(len(pairs) / (len(pairs) - 1.0))
        return DiscretisationError(mean, deviations, usual)


def _alone(plant: Plant, values: dict[str, float], group: Group) -> Channels | None:
    try:
        return plant.simulate(values, group.recording)
    except ComputationFailed:
        return None
