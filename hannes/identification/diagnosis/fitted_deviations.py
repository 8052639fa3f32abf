"""What like parts are off for themselves by the fitted recordings, in runs simulated whole.

A fit takes the parts' own deviations as uncertain, beside those that its machine has: its
chi-squared is the least over all of them. A run that is simulated without them leaves what they
would have explained. So their means, given the fitted recordings, are added to the runs that a
decision must stand on. Recordings that were not fitted say nothing of them.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.part_deviations import PartDeviations, changes_of
from hannes.identification.diagnosis.repeat_groups import Channels, Group, grouped
from hannes.plants.protocol import Plant

Runs = Sequence[Sequence[Channels | None]]


def with_deviations(
    made: Runs, entries: Sequence[Entry], points: Sequence[Linearisation], variance_factor: float
) -> list[list[Channels | None]]:
    """The runs of each entry at each point, with the parts as off as the fit there has them.

    made: at the machine as given, then at `points`. As given nothing is off.
    """
    parts = points[0].noise.parts
    if parts is None:
        return [list(each) for each in made]
    sizes = [_beyond(parts.at, deviations(point, variance_factor)) for point in points]
    changes = _changes(points[0], parts, entries)
    return [
        [each[0], *(_moved(run, size, changes[id(entry)])
                    for run, size in zip(each[1:], sizes, strict=True))]
        for entry, each in zip(entries, made, strict=True)
    ]  # fmt: skip


def _beyond(at: Mapping[str, float], sizes: Mapping[str, float]) -> dict[str, float]:
    """Deviations beyond those that the simulated machine has."""
    return {name: size - at.get(name, 0.0) for name, size in sizes.items()}


def deviations(point: Linearisation, variance_factor: float) -> dict[str, float]:
    """Mean deviation of each part given the fitted recordings, in its standard deviations, by row.

    variance_factor: of the noise that repeats show over the simulated one
    """
    noise = point.noise
    if noise.parts is None:
        return {}
    groups = noise.model.groups
    rows = np.concatenate(
        [noise.white(k, each) for k, each in enumerate(noise.parts.rows(groups))], axis=-1
    )
    left = np.concatenate(
        [
            noise.white(k, group.mean - made - expected)
            for k, (group, made, expected) in enumerate(
                zip(groups, point.vectors, noise.expected, strict=True)
            )
        ]
    )
    weights = rows @ rows.T + variance_factor * np.eye(len(rows))
    return dict(zip(noise.parts.names, np.linalg.solve(weights, rows @ left), strict=True))


def _changes(
    point: Linearisation, parts: PartDeviations, entries: Sequence[Entry]
) -> dict[int, Mapping[str, Channels]]:
    """Changes of an entry's channels by one standard deviation of each part, by the entry's id."""
    model = point.model
    pairs = zip(model.groups, parts.changes, strict=True)
    known = {_command(model.small, group): own for group, own in pairs}
    found: dict[int, Mapping[str, Channels]] = {}
    for group in grouped(model.small, entries):
        own = known.get(_command(model.small, group)) or changes_of(model, group, point.x)
        found.update({id(entry): own for entry in group.entries})
    return found


def _command(plant: Plant, group: Group) -> tuple[object, ...]:
    """Equal for groups that one simulation serves."""
    return plant.same_run(group.recording), group.names, len(group.recording)


def _moved(
    run: Channels | None, sizes: Mapping[str, float], changes: Mapping[str, Channels]
) -> Channels | None:
    if run is None:
        return None
    found = dict(run)
    for name, change in changes.items():
        for channel, values in change.items():
            if channel in found:
                found[channel] = found[channel] + sizes.get(name, 0.0) * values
    return found
