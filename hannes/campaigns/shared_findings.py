"""Faults of a sensor that most repeats show at the same time: the machine may do that itself.

An encoder slips and a sensor drops out by accident, in one run. A motor that stalls at its supply's
limit, or a supply that sags, looks alike in one recording, and comes back in other repeats. What it
does under one command it may do for a moment under another.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.quality.finding import Finding

STOOD = "frozen"  # kind of a sensor that stands for a while, by its size [s]
ACCIDENTS = ("slip", STOOD)  # kinds of faults that no two runs share; of one stall either
FEWEST = 2  # repeats that show it
TOGETHER = 0.2  # of a run's duration, within which it begins

Named = Sequence[tuple[str, list[Finding]]]


@dataclass(frozen=True)
class Shared:
    """That repeats of a condition show one; longest: for how long a sensor stands there [s]."""

    condition: str
    count: int
    repeats: int
    longest: float

    @property
    def text(self) -> str:
        """`3 of 4 repeats of dynamometer show it at the same time`."""
        who = f"{self.count} of {self.repeats} repeats of {self.condition}"
        return f"{who} show it at the same time, so the machine may do that itself"


def with_shared_as_warnings(campaign: Campaign, found: Named) -> list[tuple[str, list[Finding]]]:
    """The same findings of a campaign; accidents of a channel that repeats share are warnings."""
    conditions = {each.name: each.condition for each in campaign.entries}
    of_channels = {each.channel for _, some in found for each in some if _is_accident(each)}
    shared = {name: _shared(campaign, dict(found), name) for name in of_channels}

    def judged(name: str, one: Finding) -> Finding:
        known = shared.get(one.channel, [])
        there = [e for e in known if _is_accident(one) and _is_of(one, conditions.get(name, ""), e)]
        text = f"{one.text}; {there[0].text}" if there else ""
        return replace(one, level="warning", text=text) if there else one

    return [(name, [judged(name, each) for each in findings]) for name, findings in found]


def _is_accident(one: Finding) -> bool:
    return one.level == "fault" and one.kind in ACCIDENTS


def _is_of(one: Finding, condition: str, shared: Shared) -> bool:
    """Whether an accident is one that is shared, or as brief a one under another command."""
    brief = one.kind == STOOD and (one.size or np.inf) <= shared.longest
    return condition == shared.condition or brief


def _shared(campaign: Campaign, found: Mapping[str, list[Finding]], channel: str) -> list[Shared]:
    """The conditions of which most repeats show an accident of a channel."""
    conditions: dict[str, list[Entry]] = {}
    for each in campaign.entries:
        if each.name in found:
            conditions.setdefault(each.condition, []).append(each)
    made = []
    for condition, entries in conditions.items():
        some = [_first(found[each.name], channel) for each in entries]
        times = np.array([np.nan if each is None else each.time or 0.0 for each in some])
        near = TOGETHER * float(np.ptp(entries[0].recording.time))
        count = max(np.count_nonzero(np.abs(times - each) <= near) for each in times)
        if count >= FEWEST and 2 * count > len(entries):
            longest = max((e.size or 0.0 for e in some if e and e.kind == STOOD), default=0.0)
            made.append(Shared(condition, int(count), len(entries), longest))
    return made


def _first(findings: Sequence[Finding], channel: str) -> Finding | None:
    """The first accident of a channel, or None."""
    there = (each for each in findings if _is_accident(each) and each.channel == channel)
    return next(there, None)
