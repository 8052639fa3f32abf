"""Warnings about the recordings of a campaign, given before any of them is fitted."""

from collections.abc import Iterator, Sequence

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.check import check, refuse_faults
from hannes.campaigns.mixed_runs import mixed_runs
from hannes.campaigns.periodicity import inputs
from hannes.campaigns.quality.finding import Finding, warning

SUPPLY = "supply"
FEWEST_FALLING = 4  # recordings of which a fall is seen
FALL, CLEAR = 0.02, 3.0  # of the mean, and standard deviations about a line
FEWEST_REPEATS = 5  # that separate two machines from one that scatters; two at least of each
SAME = 1e-2  # by which commands and lengths of repeats may differ
APART = 3.5  # nearest two of different machines, in distances of the farthest two of one machine


def campaign_warnings(campaign: Campaign) -> list[str]:
    """One line for each kind of warning; BadInput where the data check finds a fault.

    A fault (a wrong unit, a reversed sign, a dead channel) would be named as an effect.
    """
    found = [(each.name, check(each.recording, campaign.plant)) for each in campaign.entries]
    across = across_runs(campaign)
    refuse_faults([*found, ("the campaign", across)])
    kinds: dict[tuple[str, str], list[tuple[str, Finding]]] = {}
    for name, findings in found:
        for each in findings:
            if each.level == "warning":
                kinds.setdefault((each.kind, each.channel), []).append((name, each))
    lines = [_line(group, len(found)) for group in kinds.values()]
    return [*lines, *_units(campaign), *map(str, across)]


def across_runs(campaign: Campaign) -> list[Finding]:
    """What only several recordings show: two machines mixed, a supply that falls."""
    faults = list(mixed_runs(campaign))
    return [*(faults or _mixed(campaign)), *_supply(campaign)]


def _supply(campaign: Campaign) -> Iterator[Finding]:
    """A supply voltage that falls from run to run, by more than it scatters."""
    entries = [each for each in campaign.entries if SUPPLY in each.recording]
    if len(entries) < FEWEST_FALLING:
        return
    levels = np.array([float(np.median(each.recording[SUPPLY])) for each in entries])
    count = np.arange(levels.size)
    slope, first = np.polyfit(count, levels, 1)
    scatter = float(np.std(levels - first - slope * count))
    fall = float(-slope * (levels.size - 1))
    if fall < max(FALL * float(levels.mean()), CLEAR * scatter):
        return
    unit = entries[0].recording.units[SUPPLY]
    yield warning(
        "supply",
        SUPPLY,
        f"falls by {fall:.3g} {unit} from {entries[0].name} to {entries[-1].name}: a battery runs "
        "down, and later runs are slower; charge it, or diagnose the first runs apart",
        size=fall,
    )


def _line(found: Sequence[tuple[str, Finding]], count: int) -> str:
    name, first = found[0]
    where = "" if len(found) == 1 else f"{len(found)} of {count} recordings, such as "
    return f"{where}{name}: {first}"


def _units(campaign: Campaign) -> Iterator[str]:
    """Units that are taken as one machine."""
    units = list(dict.fromkeys(each.unit for each in campaign.entries))
    if len(units) > 1:
        yield (
            f"recordings of {len(units)} units ({', '.join(unit or 'unnamed' for unit in units)}) "
            "are taken as of one machine: diagnose each by a campaign of its own"
        )


def _mixed(campaign: Campaign) -> Iterator[Finding]:
    """Repeats that form two clusters, far apart and each compact."""
    for condition in dict.fromkeys(each.condition for each in campaign.entries):
        entries = _repeats(campaign, condition)
        for channel in campaign.plant.judged:
            if len(entries) < FEWEST_REPEATS or any(channel not in e.recording for e in entries):
                continue
            one, other = _clusters(
                np.array([_aligned(each, entries[0], channel) for each in entries])
            )
            if one:
                parts = [", ".join(entries[k].name for k in each) for each in (one, other)]
                yield warning(
                    "mixed",
                    channel,
                    f"the repeats of {condition} form two clusters by {channel}, {parts[0]} and "
                    f"{parts[1]}: recordings of two machines, or before and after a change? "
                    "diagnose them apart",
                )
                break


def _repeats(campaign: Campaign, condition: str) -> list[Entry]:
    """Recordings of a condition with the command and the length of its first one."""
    entries = [each for each in campaign.entries if each.condition == condition]
    first, driving = entries[0], inputs(campaign.plant, entries[0].recording)
    return [each for each in entries if _same(each, first, driving)]


def _same(entry: Entry, first: Entry, driving: Sequence[str]) -> bool:
    lasts = [float(np.ptp(each.recording.time)) for each in (entry, first)]
    if abs(lasts[0] / lasts[1] - 1.0) > SAME:
        return False
    return all(
        name in entry.recording
        and np.abs(_aligned(entry, first, name) - first.recording[name]).max()
        <= SAME * np.ptp(first.recording[name])
        for name in driving
    )


def _aligned(entry: Entry, first: Entry, channel: str) -> np.ndarray:
    """A channel at the times of another recording, both counted from their start."""
    at, time = (each.recording.time - each.recording.time[0] for each in (first, entry))
    return np.interp(at, time, entry.recording[channel])


def _clusters(runs: np.ndarray) -> tuple[list[int], list[int]]:
    """Numbers of the runs (m, n) of two clusters; both empty where there is one.

    Single linkage separates at the widest gap.
    """
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import pdist, squareform

    distances = pdist(runs)
    label = fcluster(linkage(distances, "single"), 2, "maxclust")
    clusters = [np.flatnonzero(label == k).tolist() for k in (1, 2)]
    if min(map(len, clusters)) < 2:
        return [], []
    square = squareform(distances)
    between = square[np.ix_(*clusters)].min()
    within = max(square[np.ix_(each, each)].max() for each in clusters)
    return (clusters[0], clusters[1]) if between > APART * within else ([], [])
