"""What the recordings of a campaign are to be taken with, told before any of them is fitted."""

from collections.abc import Iterator, Sequence

import numpy as np

from hannes.campaign import Campaign, Entry
from hannes.check import check, refuse_faults
from hannes.findings.finding import Finding
from hannes.plant import Plant

FEWEST_REPEATS = 5  # to tell two machines from one that scatters; two at least of each
APART = 3.5  # nearest two of different machines, in distances of the farthest two of one machine


def cautions(campaign: Campaign) -> list[str]:
    """One line for each kind of warning; BadInput where the data check finds a fault.

    A fault (a wrong unit, a reversed sign, a dead channel) would be named as an effect.
    """
    found = [(each.name, check(each.recording, campaign.plant)) for each in campaign.entries]
    refuse_faults(found)
    kinds: dict[tuple[str, str], list[tuple[str, Finding]]] = {}
    for name, findings in found:
        for each in findings:
            if each.level == "warning":
                kinds.setdefault((each.kind, each.channel), []).append((name, each))
    return [_line(told, len(found)) for told in kinds.values()] + list(_mixed(campaign))


def _line(told: Sequence[tuple[str, Finding]], count: int) -> str:
    name, first = told[0]
    where = "" if len(told) == 1 else f"{len(told)} of {count} recordings, such as "
    return f"{where}{name}: {first}"


def _mixed(campaign: Campaign) -> Iterator[str]:
    """Repeats that fall into two heaps, far apart and each close together."""
    for condition, entries in _repeats(campaign.plant, campaign.entries):
        for channel in campaign.plant.judged:
            if all(channel in each.recording for each in entries):
                one, other = _heaps(np.array([each.recording[channel] for each in entries]))
                if one:
                    parts = [", ".join(entries[k].name for k in heap) for heap in (one, other)]
                    yield (
                        f"the repeats of {condition} fall into two heaps by {channel}, "
                        f"{parts[0]} and {parts[1]}: recordings of two machines, or before and "
                        "after a change? diagnose them apart"
                    )
                    break


def _repeats(plant: Plant, entries: Sequence[Entry]) -> Iterator[tuple[str, list[Entry]]]:
    groups: dict[tuple[str, bytes], list[Entry]] = {}
    for each in entries:
        groups.setdefault((each.condition, plant.same_run(each.recording)), []).append(each)
    for (condition, _), group in groups.items():
        if len(group) >= FEWEST_REPEATS:
            yield condition, group


def _heaps(runs: np.ndarray) -> tuple[list[int], list[int]]:
    """Numbers of the runs (m, n) of two heaps; both empty where there is one.

    Single linkage cuts at the widest gap.
    """
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import pdist, squareform

    distances = pdist(runs)
    label = fcluster(linkage(distances, "single"), 2, "maxclust")
    heaps = [np.flatnonzero(label == k).tolist() for k in (1, 2)]
    if min(map(len, heaps)) < 2:
        return [], []
    square = squareform(distances)
    between = square[np.ix_(*heaps)].min()
    within = max(square[np.ix_(heap, heap)].max() for heap in heaps)
    return (heaps[0], heaps[1]) if between > APART * within else ([], [])
