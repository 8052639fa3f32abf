"""Earlier and later repeats apart, where what an effect moves by run is seen to change.

Means over repeats say little of a change from run to run where commands take turns. Halves do.
"""

from collections.abc import Sequence

import numpy as np

from hannes.core.effect import Effect
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.plants.part_fault import moved_by, moves_by_run

CHANCE = 1e-3  # of a slope over the order of runs, by chance


def in_order(groups: Sequence[Group], effects: Sequence[Effect]) -> list[Group]:
    """The groups, or their earlier and later halves where a channel changes steadily by runs.

    The channels asked are those called as the part that an effect moves by run: the supply.
    """
    moved = {
        name.partition(".")[0]
        for effect in effects
        if moves_by_run(effect)
        for amplitude in effect.amplitudes
        for name in moved_by(effect, amplitude.name)
    }
    if not any(changes_steadily(groups, channel) for channel in sorted(moved)):
        return list(groups)
    return [half for group in groups for half in _halves(group)]


def changes_steadily(groups: Sequence[Group], channel: str) -> bool:
    """Whether means of a channel go with the order of repeats: Student's t of the slope."""
    from scipy.stats import t as student

    between = order = within = 0.0
    freedom = -1
    for group in groups:
        if channel in group.names:
            means = group.measured[:, group.of(channel)].mean(axis=1)
            values, numbers = means - means.mean(), group.numbers - group.numbers.mean()
            between, order = between + float(values @ numbers), order + float(numbers @ numbers)
            within, freedom = within + float(values @ values), freedom + group.count - 1
    if freedom < 1 or order == 0.0:
        return False
    slope = between / order
    rest = max(within - slope * between, 1e-30) / freedom
    return bool(2.0 * student.sf(abs(slope) * np.sqrt(order / rest), freedom) < CHANCE)


def _halves(group: Group) -> list[Group]:
    order, first = np.argsort(group.numbers), group.count // 2
    return [group.only(sorted(some)) for some in (order[:first], order[first:]) if some.size]
