"""Where a baseline fit starts: as given, or elsewhere if a channel does not answer there.

A finger that never touches from the given angle has no force, and no derivative says where it would
touch. A fit from there ends where it began, and what it leaves looks like something missing.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from hannes.core.errors import BadInput, ComputationFailed
from hannes.identification.holdout.least_squares import Progress, WeightedResidual
from hannes.identification.holdout.tuning import HOLDOUT
from hannes.plants.protocol import Plant

Values = dict[str, float]


def start(residual: WeightedResidual, plant: Plant, progress: Progress) -> Values:
    """Free parameters [SI] from which every channel answers to some of them; {} as given.

    Raises BadInput where none does from any of the places tried, ComputationFailed where the
    machine as given cannot be simulated.
    """
    silent = _silent(residual, plant, {})
    if not silent:
        return {}
    progress("other starting points")
    places = sorted(_places(plant), key=lambda each: _misfit(residual, plant, each))
    for place in places[: HOLDOUT.starts_looked_at]:
        if not _silent(residual, plant, place):
            return place
    names = ", ".join(name for name, size in plant.free.items() if size > 0.0)
    raise BadInput(
        f"the simulated {' and '.join(silent)} does not answer to {names}, as given and at "
        f"{len(places)} other places: it is not the machine of these recordings; set base to one "
        "that is nearer"
    )


def _silent(residual: WeightedResidual, plant: Plant, values: Values) -> list[str]:
    """Channels that change in the recordings, but by no step of any free parameter."""
    here, found = residual.raw(plant, values), []
    moved = [residual.raw(plant, each) for each in _stepped(plant, values)]
    for name in residual.noise_floors:
        recorded = [s.recording[name][s.mask] for s in residual.segments if name in s.recording]
        alive = any(float(np.ptp(each)) > residual.noise_floors[name] for each in recorded)
        if alive and moved and not any(_apart(here, each, name) for each in moved):
            found.append(name)
    return found


def _apart(
    one: Sequence[Mapping[str, np.ndarray]], other: Sequence[Mapping[str, np.ndarray]], name: str
) -> bool:
    pairs = zip(one, other, strict=True)
    return any(name in a and not np.array_equal(a[name], b[name]) for a, b in pairs)


def _stepped(plant: Plant, values: Values) -> list[Values]:
    """The values with each free parameter a step up, then down."""
    return [
        values | {name: _within(plant, name, _at(plant, values, name) + side * size)}
        for side in (HOLDOUT.difference_steps[0], -HOLDOUT.difference_steps[0])
        for name, size in _sizes(plant).items()
    ]


def _places(plant: Plant) -> list[Values]:
    """Places around the given one: each parameter alone, and all at once in a Sobol sequence."""
    from scipy.stats import qmc

    sizes = _sizes(plant)
    alone = [
        {name: _within(plant, name, plant.parameters[name] + shift * size)}
        for shift in HOLDOUT.starts_alone
        for name, size in sizes.items()
    ]
    drawn = qmc.Sobol(len(sizes), seed=0).random_base2(HOLDOUT.starts_together)
    together = [
        {
            name: _within(plant, name, plant.parameters[name] + float(shift) * size)
            for (name, size), shift in zip(sizes.items(), row, strict=True)
        }
        for row in HOLDOUT.starts_alone[-1] * (2.0 * drawn - 1.0)
    ]
    return [*alone, *together]


def _misfit(residual: WeightedResidual, plant: Plant, values: Values) -> float:
    """Squares of the weighted residual, infinite where a simulation fails."""
    try:
        return float(np.sum(residual.weighted(residual.raw(plant, values)) ** 2))
    except ComputationFailed:
        return float("inf")


def _sizes(plant: Plant) -> Values:
    return {name: size for name, size in plant.free.items() if size > 0.0}


def _at(plant: Plant, values: Values, name: str) -> float:
    return values.get(name, plant.parameters[name])


def _within(plant: Plant, name: str, value: float) -> float:
    low, high = plant.parameters.declared[name].bounds
    return float(min(high, max(low, value)))
