"""Faults of a sensor that all repeats show at the same time: the machine may do that itself.

An encoder slips and a sensor drops out by accident, in one run. A motor that stalls at its supply's
limit, or a supply that sags, looks alike in one recording, and comes back in every repeat.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hannes.campaigns.campaign import Campaign
from hannes.campaigns.quality.finding import Finding

ACCIDENTS = ("slip", "frozen")  # kinds of faults that no two runs share
FEWEST = 2  # repeats that show it
TOGETHER = 0.05  # of a run's duration, within which it begins
ALIKE = 2.0  # ratio of its sizes, at most

Named = Sequence[tuple[str, list[Finding]]]


def with_shared_as_warnings(campaign: Campaign, found: Named) -> list[tuple[str, list[Finding]]]:
    """The same findings by recording; accidents that all repeats share are warnings."""
    conditions = {each.name: each.condition for each in campaign.entries}
    lasting = {each.name: float(np.ptp(each.recording.time)) for each in campaign.entries}
    by_name = dict(found)

    def judged(name: str, one: Finding) -> Finding:
        if one.level != "fault" or one.kind not in ACCIDENTS or name not in conditions:
            return one
        alike = [n for n, each in conditions.items() if each == conditions[name] and n in by_name]
        near = TOGETHER * lasting[name]
        if len(alike) < FEWEST or not all(_has(by_name[n], one, near) for n in alike):
            return one
        text = (
            f"{one.text}; all {len(alike)} repeats show it then, so the machine may do that itself"
        )
        return replace(one, level="warning", text=text)

    return [(name, [judged(name, each) for each in findings]) for name, findings in found]


def _has(findings: Sequence[Finding], one: Finding, near: float) -> bool:
    """Whether a recording has such a fault at that time [s], about as large."""
    return any(
        (each.kind, each.channel) == (one.kind, one.channel)
        and abs((each.time or 0.0) - (one.time or 0.0)) <= near
        and abs(one.size or 1.0) / ALIKE <= abs(each.size or 1.0) <= ALIKE * abs(one.size or 1.0)
        for each in findings
    )
