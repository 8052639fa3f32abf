"""Faults of a sensor that most repeats show at the same time: the machine may do that itself.

An encoder slips and a sensor drops out by accident, in one run. A motor that stalls at its supply's
limit, or a supply that sags, looks alike in one recording, and comes back in other repeats. What it
does under one command it may do under another, for a moment.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.quality.finding import Finding

ACCIDENTS = ("slip", "frozen")  # kinds of faults that no two runs share; of one stall either
FEWEST = 2  # repeats that show it
TOGETHER = 0.2  # of a run's duration, within which it begins

Named = Sequence[tuple[str, list[Finding]]]


def with_shared_as_warnings(campaign: Campaign, found: Named) -> list[tuple[str, list[Finding]]]:
    """The same findings by recording; accidents of a channel that repeats share are warnings."""
    of_channels = {each.channel for _, some in found for each in some if _is_accident(each)}
    shared = {name: how for name in of_channels if (how := _shared(campaign, dict(found), name))}

    def judged(one: Finding) -> Finding:
        if not _is_accident(one) or one.channel not in shared:
            return one
        text = f"{one.text}; {shared[one.channel]}, so the machine may do that itself"
        return replace(one, level="warning", text=text)

    return [(name, [judged(each) for each in findings]) for name, findings in found]


def _is_accident(one: Finding) -> bool:
    return one.level == "fault" and one.kind in ACCIDENTS


def _shared(campaign: Campaign, found: dict[str, list[Finding]], channel: str) -> str:
    """`3 of 4 repeats of dynamometer show it at the same time`; empty where no condition does."""
    conditions: dict[str, list[Entry]] = {}
    for each in campaign.entries:
        if each.name in found:
            conditions.setdefault(each.condition, []).append(each)
    for condition, entries in conditions.items():
        times = np.array([_time(found[each.name], channel) for each in entries])
        near = TOGETHER * float(np.ptp(entries[0].recording.time))
        count = max(np.count_nonzero(np.abs(times - each) <= near) for each in times)
        if count >= FEWEST and 2 * count > len(entries):
            return f"{count} of {len(entries)} repeats of {condition} show it at the same time"
    return ""


def _time(findings: Sequence[Finding], channel: str) -> float:
    """When an accident of a channel begins [s]; nan without."""
    there = (each for each in findings if _is_accident(each) and each.channel == channel)
    return next((float(each.time or 0.0) for each in there), np.nan)
