"""What like parts of a machine are off for themselves: alike in all runs, free in every fit.

Fingers are made alike and are not alike. A machine's parameters hold for all of them. What each
joint is off for itself changes a run a little, and no value of the machine does the same. So these
changes are simulated one by one at the baseline, and their covariance joins the noise of all runs
together: a fit may move every part within its scatter, at no further simulation. With contacts a
change is not the reverse of the opposite one: a finger that touches first may touch earlier, and
not later. What both have in common is a row of its own. So is what both ways of some machines have
in common whose parts are all off at once: what parts do together is not the sum of what each does.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from hannes.identification.diagnosis.repeat_groups import Channels, Group
from hannes.identification.diagnosis.simulator import Model

EITHER = ", either way"  # ends the name of what both changes by a part share


@dataclass(frozen=True)
class PartDeviations:
    """Changes of each group's channels by one standard deviation of each part: row -> channels.

    at: how far parts of the simulated machine are off already, in these, by row
    """

    changes: Sequence[dict[str, Channels]]
    at: Mapping[str, float] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the rows, in their order."""
        return tuple(dict.fromkeys(name for own in self.changes for name in own))

    def rows(self, groups: Sequence[Group]) -> list[np.ndarray]:
        """The same in the bins of these groups, in their order, shape (rows, n) each."""
        names = self.names
        return [
            np.array([_binned(group, own.get(name)) for name in names]).reshape(-1, group.part.size)
            for group, own in zip(groups, self.changes, strict=True)
        ]

    def only(self, numbers: Sequence[int]) -> "PartDeviations":
        """Of the groups of these numbers."""
        return PartDeviations([self.changes[k] for k in numbers], self.at)

    def explained(self, groups: Sequence[Group]) -> list[np.ndarray]:
        """What the deviations of the simulated machine change in these groups, shape (n,) each.

        By their rows: parts are expected to be off by nothing, and the machine is.
        """
        sizes = np.array([self.at.get(name, 0.0) for name in self.names])
        return [sizes @ rows for rows in self.rows(groups)]


def _binned(group: Group, change: Channels | None) -> np.ndarray:
    return np.zeros(group.part.size) if change is None else group.vector(change)


def part_deviations(model: Model, x: np.ndarray) -> PartDeviations | None:
    """Of all groups at x; None where the plant has no like parts, or these do not scatter."""
    if not model.space.settings.scatter_apart:
        return None
    found = [changes_of(model, group, x) for group in model.groups]
    return PartDeviations(found, model.parts_at) if any(found) else None


def changes_of(model: Model, group: Group, x: np.ndarray) -> dict[str, Channels]:
    """Changes of one group's channels at x by one standard deviation of each part, by row."""
    asked = group, x, model.space.settings.scatter_apart
    return dict(_rows(model.apart(*asked))) | dict(_drawn(model.together(*asked)))


def of_parts(rows: Mapping[str, float]) -> dict[str, float]:
    """Those of single parts, one way."""
    return {name: each for name, each in rows.items() if name + EITHER in rows}


def _drawn(draws: Sequence[tuple[Channels, Channels]]) -> Iterator[tuple[str, Channels]]:
    """What both ways of each draw share, as rows whose covariance is their mean square.

    Of all groups a draw is the same machine, so one that fails in one of them is left out there.
    """
    for number, (up, down) in enumerate(draws, 1):
        if not (up and down):
            continue
        shared = {n: 0.5 * (up[n] + down[n]) / len(draws) ** 0.5 for n in up}
        yield f"all parts, draw {number}", shared


def _rows(own: Mapping[str, tuple[Channels, Channels]]) -> Iterator[tuple[str, Channels]]:
    """Of each part what its two changes do not share, and what they do."""
    for name, (up, down) in own.items():
        yield name, {n: 0.5 * (up[n] - down[n]) for n in up}
        yield name + EITHER, {n: 0.5 * (up[n] + down[n]) for n in up}
