"""The parameter space: all uncertain parameters, and the parameters of every candidate effect."""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.campaigns.earlier_runs import after
from hannes.core.effect import Effect
from hannes.core.parameter import Parameter, ParameterSet
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.tuning import FIT
from hannes.plants.part_fault import moved_by, moves_by_run
from hannes.plants.protocol import Plant


@dataclass(frozen=True)
class FreeParameter:
    """One number x that a fit may move: value = centre + scale x, in SI, within bounds.

    owner: what the parameter belongs to where it is not the machine's;  effect: name of its effect
    moves: the machine's parameters that it moves, where it is no parameter of a model itself
    by_run: whether earlier runs of the campaign decide how much it does
    """

    name: str
    owner: str
    centre: float
    scale: float
    low: float
    high: float
    weight: float = 1.0
    effect: str = ""
    moves: Mapping[str, float] = field(default_factory=dict, hash=False)
    by_run: bool = False

    def value(self, x: np.ndarray | float) -> np.ndarray:
        """Parameter [SI] at x."""
        return np.clip(self.centre + self.scale * np.asarray(x), self.low, self.high)

    def x(self, value: float) -> float:
        """Where a parameter has a value [SI]."""
        return (value - self.centre) / self.scale


class ParameterSpace:
    """All free parameters: the uncertain ones first, then those of the candidate effects."""

    def __init__(
        self, plant: Plant, groups: Sequence[Group], settings: Settings, effects: Sequence[Effect]
    ) -> None:
        self.effects = {each.name: each for each in effects}
        self._stated = self._simulated = plant.parameters
        known = _uncertain(plant, groups, settings)
        self.parameters = [*known, *_of_effects(effects)]
        self.uncertain = np.arange(len(known))
        self.prior = np.array([np.sqrt(each.weight) for each in self.parameters])
        self.low = np.array([(d.low - d.centre) / d.scale for d in self.parameters])
        self.high = np.array([(d.high - d.centre) / d.scale for d in self.parameters])
        self.settings = settings
        self._acting: dict[str, np.ndarray] = {}

    def simulating(self, values: ParameterSet) -> "ParameterSpace":
        """The same where other values of what is certain of the machine are simulated."""
        made = copy(self)
        made._simulated = values
        return made

    @property
    def size(self) -> int:
        """Number of parameters."""
        return len(self.parameters)

    def acting(self, group: Group) -> np.ndarray:
        """Which parameters change a group, shape (size,)."""
        if group.owner not in self._acting:
            owners = [each.owner for each in self.parameters]
            self._acting[group.owner] = np.array([not o or o == group.owner for o in owners])
        return self._acting[group.owner]

    @cached_property
    def _places(self) -> dict[str, list[int]]:
        found: dict[str, list[int]] = {name: [] for name in self.effects}
        for place, each in enumerate(self.parameters):
            if each.effect:
                found[each.effect].append(place)
        return found

    @cached_property
    def _earlier(self) -> dict[str, str]:
        """What earlier runs set of effects, by full name -> what they did."""
        return {
            effect.full_name(each.name): each.earlier
            for effect in self.effects.values()
            for each in effect.parameters
            if each.earlier
        }

    @cached_property
    def by_run(self) -> np.ndarray:
        """Which parameters do what earlier runs decide, shape (size,)."""
        return np.array([each.by_run for each in self.parameters], bool)

    def of(self, *effects: str) -> np.ndarray:
        """Indices of the parameters of these effects."""
        return np.array([place for name in effects for place in self._places[name]], int)

    def place(self, name: str) -> int:
        """Index of an effect's parameter, by full name."""
        return next(k for k, d in enumerate(self.parameters) if d.effect and d.name == name)

    def columns(self, group: Group, rows: np.ndarray, effects: bool) -> dict[str, np.ndarray]:
        """Parameters by full name [SI] for rows of x, shape (m, size)."""
        places = self._shown(group, effects)
        chosen = [self.parameters[place] for place in places]
        centre, scale, low, high = (
            np.array([(each.centre, each.scale, each.low, each.high) for each in chosen])
            .reshape(-1, 4)
            .T[:, :, np.newaxis]
        )
        values = np.clip(centre + scale * rows.T[places], low, high)
        found = dict(zip((each.name for each in chosen), values, strict=True))
        if not effects:
            return found
        for name, earlier in self._earlier.items():
            found[name] = np.full(len(rows), float(group.earlier[earlier].mean()))
        return self._moved(found, rows, self._simulated, float(group.numbers.mean()))

    def _shown(self, group: Group, effects: bool) -> list[int]:
        """Indices of what is a parameter of a group's model, with or without those of effects."""
        acting = self.acting(group)
        return [
            place
            for place, each in enumerate(self.parameters)
            if acting[place] and not each.moves and (effects or not each.effect)
        ]

    def _moved(
        self,
        columns: dict[str, np.ndarray],
        rows: np.ndarray,
        certain: ParameterSet,
        before: float = 0.0,
    ) -> dict[str, np.ndarray]:
        """Columns with what faults of parts move; rows of x, shape (m, size).

        certain: values of what is no column;  before: how many runs of the campaign came before
        """
        for place, each in enumerate(self.parameters):
            if not each.moves or not rows[:, place].any():
                continue
            times = before if each.by_run else 1.0
            for name, change in each.moves.items():
                low, high = certain.declared[name].bounds
                here = columns.get(name, certain[name])
                columns[name] = np.clip(
                    here + times * change * each.value(rows[:, place]), low, high
                )
        return columns

    def values(self, x: np.ndarray, owner: str = "") -> dict[str, float]:
        """Parameters of the stated machine at x [SI], with those of one owner."""
        columns = {
            d.name: d.value(x[k : k + 1])
            for k, d in enumerate(self.parameters)
            if not d.moves and (not d.owner or d.owner == owner)
        }
        moved = self._moved(columns, x[np.newaxis], self._stated)
        return {name: float(each[0]) for name, each in moved.items()}

    def after_all(self, entries: Sequence[Entry]) -> dict[str, float]:
        """What earlier runs set of effects, by full name [SI], of a run that follows all these."""
        last = max(entries, key=lambda each: each.number)
        done = after(last.earlier, last.recording) if self._earlier else {}
        return {name: done[what] for name, what in self._earlier.items() if what in done}

    def declared(self, name: str) -> Parameter:
        """Declaration of an effect's parameter, by full name."""
        effect = self.effects[self.parameters[self.place(name)].effect]
        return next(each for each in effect.parameters if effect.full_name(each.name) == name)


def _uncertain(plant: Plant, groups: Sequence[Group], settings: Settings) -> list[FreeParameter]:
    """One parameter for each uncertain one of the machine, and of each object it handles."""
    sizes: Mapping[str, float] = getattr(plant, "uncertain", {})
    owners = {group.owner: group for group in groups}
    apart = {name for group in groups for name in group.own}
    found = [
        _direction(plant, name, "", plant.parameters[name], settings.scatter * size)
        for name, size in sizes.items()
        if name not in apart
    ]
    for owner, group in owners.items():
        for name in group.own:
            if name in sizes:
                value = group.nominal[name]
                scaled = sizes[name] * _ratio(value, plant.parameters[name], sizes[name])
                found.append(_direction(plant, name, owner, value, settings.scatter * scaled))
    return found


def _ratio(value: float, usual: float, size: float) -> float:
    """Factor of a size that is a share of the nominal value; 1 for an absolute size."""
    return abs(value / usual) if usual and np.isclose(size, abs(usual)) else 1.0


def _direction(plant: Plant, name: str, owner: str, value: float, scale: float) -> FreeParameter:
    low, high = plant.parameters.declared[name].bounds
    return FreeParameter(name, owner, value, scale or 1.0, low, high)


def _of_effects(effects: Sequence[Effect]) -> list[FreeParameter]:
    return [_of_effect(effect, each) for effect in effects for each in effect.fitted]


def _of_effect(effect: Effect, parameter: Parameter) -> FreeParameter:
    """Of an effect's parameter, with a prior that hardly holds it."""
    low, high = parameter.bounds
    span = _span(parameter)
    centre = parameter.value if parameter.off is None else parameter.off
    return FreeParameter(
        effect.full_name(parameter.name),
        "",
        centre,
        span / FIT.steps_per_range,
        low,
        high,
        FIT.effect_prior_weight * (span / (high - low)) ** 2,
        effect.name,
        moved_by(effect, parameter.name),
        moves_by_run(effect) or effect.grows,
    )


def _span(parameter: Parameter) -> float:
    """Over what an effect may be linear: its range, or the distance of values tried.

    The signature of a count changes within less than one.
    """
    tried = np.unique(parameter.tried)
    if tried.size > 1:
        return float(np.diff(tried).min())
    return parameter.bounds[1] - parameter.bounds[0]
