"""Where a baseline fit starts: as given, or elsewhere if a channel does not answer there.

A finger that never touches from the given angle has no force, and no derivative says where it would
touch. A fit from there ends where it began, and what it leaves looks like something missing.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hannes.core.errors import BadInput, ComputationFailed
from hannes.core.recording.white_noise import rounding
from hannes.identification.holdout.least_squares import Progress, WeightedResidual
from hannes.identification.holdout.tuning import HOLDOUT
from hannes.plants.protocol import Plant

Values = dict[str, float]
Raw = Sequence[Mapping[str, np.ndarray]]  # of each segment: channel -> simulated minus recorded


def start(residual: WeightedResidual, plant: Plant, progress: Progress) -> Values:
    """Free parameters [SI] from which every channel answers to some of them; {} as given.

    As given too where some channel answers nowhere, and another one does: what is recorded in the
    first may be what is missing. Raises BadInput where none answers at any of the places tried,
    ComputationFailed where the machine as given cannot be simulated.
    """
    here = residual.raw(plant, {})
    if not (silent := _silent(residual, plant, {}, here)):
        return {}
    progress("other starting points")
    places = sorted(_places(plant), key=lambda each: _misfit(residual, plant, each))
    for place in places[: HOLDOUT.starts_looked_at]:
        there = _tried(residual, plant, place)
        if there is not None and not _silent(residual, plant, place, there):
            return place
    every = list(residual.noise_floors)
    if len(_deaf(residual, plant, {}, here, every, HOLDOUT.starts_alone)) < len(every):
        return {}
    names = ", ".join(name for name, size in plant.free.items() if size > 0.0)
    raise BadInput(
        f"the simulated {' and '.join(silent)} does not answer to {names}, as given and at "
        f"{len(places)} other places: it is not the machine of these recordings; set base to one "
        "that is nearer"
    )


def _silent(residual: WeightedResidual, plant: Plant, values: Values, here: Raw) -> list[str]:
    """Channels recorded otherwise than simulated, but that answer to no step of any parameter.

    here: what the values leave
    """
    names = [name for name in residual.noise_floors if _unlike(residual, here, name)]
    step = HOLDOUT.difference_steps[0]
    return _deaf(residual, plant, values, here, names, (step, -step))


def _unlike(residual: WeightedResidual, here: Raw, name: str) -> bool:
    """Whether what a channel leaves is more than noise and rounding, and no mere offset."""
    recorded = [each.recording[name] for each in residual.segments if name in each.recording]
    floor = max(residual.noise_floors[name], *(rounding(values) for values in recorded))
    return any(float(np.std(each[name])) > HOLDOUT.silent * floor for each in here if name in each)


def _deaf(
    residual: WeightedResidual,
    plant: Plant,
    values: Values,
    here: Raw,
    names: Sequence[str],
    steps: Sequence[float],
) -> list[str]:
    """Of these channels, those that no free parameter changes, whatever the step."""
    left = list(names) if _sizes(plant) else []
    for place in _stepped(plant, values, steps):
        if left and (made := _tried(residual, plant, place)) is not None:
            left = [name for name in left if not _apart(here, made, name)]
    return left


def _tried(residual: WeightedResidual, plant: Plant, values: Values) -> Raw | None:
    """What a place leaves, None where it cannot be simulated."""
    try:
        return residual.raw(plant, values)
    except ComputationFailed:
        return None


def _apart(one: Raw, other: Raw, name: str) -> bool:
    pairs = zip(one, other, strict=True)
    return any(name in a and not np.array_equal(a[name], b[name]) for a, b in pairs)


def _stepped(plant: Plant, values: Values, steps: Sequence[float]) -> Iterator[Values]:
    """The values with each free parameter off by each step [standard deviations]."""
    for side in steps:
        for name, size in _sizes(plant).items():
            yield values | {name: _within(plant, name, _at(plant, values, name) + side * size)}


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
    made = _tried(residual, plant, values)
    return float("inf") if made is None else float(np.sum(residual.weighted(made) ** 2))


def _sizes(plant: Plant) -> Values:
    return {name: size for name, size in plant.free.items() if size > 0.0}


def _at(plant: Plant, values: Values, name: str) -> float:
    return values.get(name, plant.parameters[name])


def _within(plant: Plant, name: str, value: float) -> float:
    low, high = plant.parameters.declared[name].bounds
    return float(min(high, max(low, value)))
