"""Repeats of one command that fall into two groups: two machines under one name, or one changed.

Compared are the motion and what drives it, as means over parts of a run, each relative to the
channel's RMS. What a later start explains is left out.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.periodicity import inputs
from hannes.campaigns.quality.finding import Finding, fault, warning
from hannes.plants.protocol import expectations

FloatArray = NDArray[np.float64]

FEWEST, FEWEST_EACH = 4, 2  # runs, and of each group
MOST = 200  # runs of a condition that are compared
PARTS = 40  # of a run
SAME = 1e-2  # of its range, by which a command may differ from that of its repeats
AS_LONG = 0.2  # by which the lengths of repeats may differ
# Nearest two of different groups: relative to the channels, and over the farthest two of one
# group, for four runs and for more. Sound sets that scatter by up to 2 % have not both: see tests.
APART, CLEAR = 0.03, (5.0, 4.0)


@dataclass(frozen=True)
class _Groups:
    """Entries of two groups, the smaller (or later) one second, and how far they are apart."""

    one: list[Entry]
    other: list[Entry]
    between: float
    within: float
    channel: str


def mixed_runs(campaign: Campaign) -> Iterator[Finding]:
    """A finding for each condition whose repeats are of two machines, by all that was measured.

    A fault where they are far apart, a warning where many repeats show that they are two at all.
    """
    places = dict.fromkeys((each.condition, each.unit) for each in campaign.entries)
    for condition, unit in places:
        entries = [e for e in campaign.entries if (e.condition, e.unit) == (condition, unit)]
        found = _groups(campaign, _repeats(campaign, entries[:MOST]))
        if found is not None:
            yield _finding(condition, found)


def several_units(campaign: Campaign) -> Iterator[Finding]:
    """A warning where a fit would take the recordings of several units as one machine."""
    units = list(dict.fromkeys(each.unit for each in campaign.entries))
    if len(units) > 1:
        names = ", ".join(each or "unnamed" for each in units)
        text = f"recordings of {len(units)} units ({names}) are fitted as one machine: "
        yield warning("mixed", "unit", text + "give each a campaign of its own")


def _finding(condition: str, found: _Groups) -> Finding:
    names = ", ".join(each.name for each in found.other)
    gross = found.between >= APART
    return (fault if gross else warning)(
        "mixed",
        found.channel,
        f"the repeats of {condition} fall into two groups, {100.0 * found.between:.2g} % apart "
        f"where runs of one group differ by {100.0 * found.within:.2g} % at most: {names} are of "
        "another machine than the others, or from after a change; leave them out, or give them a "
        'campaign of their own (unit = "other" keeps them apart for `hannes compare` alone)',
        size=found.between,
    )


def _repeats(campaign: Campaign, entries: Sequence[Entry]) -> list[Entry]:
    """Entries with the command of the first, about as long."""
    first, driving = entries[0], inputs(campaign.plant, entries[0].recording)
    length = _length(first)
    return [
        each
        for each in entries
        if abs(_length(each) / length - 1.0) <= AS_LONG and _same_command(each, first, driving)
    ]


def _length(entry: Entry) -> float:
    return float(np.ptp(entry.recording.time))


def _same_command(entry: Entry, first: Entry, driving: Sequence[str]) -> bool:
    last = min(_length(entry), _length(first))
    for name in driving:
        if name not in entry.recording:
            return False
        one, other = (_parts(each, name, last) for each in (first, entry))
        if np.abs(one - other).max() > SAME * np.ptp(first.recording[name]):
            return False
    return True


def _parts(entry: Entry, name: str, last: float) -> FloatArray:
    """Means over PARTS equal parts of the first `last` seconds."""
    since = entry.recording.time - entry.recording.time[0]
    values = entry.recording[name]
    area = np.concatenate(([0.0], np.cumsum(np.diff(since) * (values[1:] + values[:-1]) / 2.0)))
    edges = np.linspace(0.0, last, PARTS + 1)
    return np.diff(np.interp(edges, since, area)) * PARTS / last


def _moved(entry: Entry, name: str, last: float) -> FloatArray:
    """What the means change by where a run is earlier, but for a factor."""
    since = entry.recording.time - entry.recording.time[0]
    edges = np.linspace(0.0, last, PARTS + 1)
    return np.diff(np.interp(edges, since, entry.recording[name]))


def _groups(campaign: Campaign, entries: list[Entry]) -> _Groups | None:
    """Two groups that are far apart, each compact; None where there are none."""
    if len(entries) < FEWEST:
        return None
    expected = expectations(campaign.plant)
    names = [
        name
        for name, each in expected.items()
        if (each.follows or each.drives) and all(name in e.recording for e in entries)
    ]
    names, runs = _relative(entries, names)
    if not names:
        return None
    apart = np.sqrt(np.mean((runs[:, np.newaxis] - runs) ** 2, axis=(2, 3)))
    one, other = _nearest(apart)
    if min(len(one), len(other)) < FEWEST_EACH:
        return None
    between = float(apart[np.ix_(one, other)].min())
    within = max(float(apart[np.ix_(each, each)].max()) for each in (one, other))
    many = len(entries) > FEWEST
    if between < CLEAR[many] * within or (between < APART and not many):
        return None
    moved = np.mean((runs[one].mean(axis=0) - runs[other].mean(axis=0)) ** 2, axis=1)
    return _Groups(
        [entries[k] for k in one],
        [entries[k] for k in other],
        between,
        within,
        names[int(np.argmax(moved))],
    )


def _relative(entries: Sequence[Entry], names: Sequence[str]) -> tuple[list[str], FloatArray]:
    """Channels (m, c, PARTS) of m runs less their mean, over each one's RMS, without later starts.

    Channels that are zero are left out.
    """
    last = min(map(_length, entries))
    parts = {name: np.array([_parts(each, name, last) for each in entries]) for name in names}
    sizes = {name: float(np.sqrt(np.mean(each**2))) for name, each in parts.items()}
    kept = [name for name in names if sizes[name] > 0.0]
    if not kept:
        return [], np.zeros((len(entries), 0, PARTS))
    runs = np.stack([parts[name] / sizes[name] for name in kept], axis=1)
    runs = (runs - runs.mean(axis=0)).reshape(len(entries), -1)
    for entry, own in zip(entries, runs, strict=True):
        later = np.concatenate([_moved(entry, name, last) / sizes[name] for name in kept])
        own -= (own @ later) / max(float(later @ later), 1e-300) * later
    return kept, runs.reshape(len(entries), len(kept), PARTS)


def _nearest(apart: FloatArray) -> tuple[list[int], list[int]]:
    """Two groups at the widest gap (single linkage), the larger, else the earlier one first."""
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    label = fcluster(linkage(squareform(apart, checks=False), "single"), 2, "maxclust")
    groups = [np.flatnonzero(label == k).tolist() for k in (1, 2)]
    one, other = sorted(groups, key=lambda each: (-len(each), each[:1]))
    return one, other
