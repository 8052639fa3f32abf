"""Warnings about the recordings of a campaign, given before any of them is fitted."""

from collections.abc import Iterator, Sequence

import numpy as np

from hannes.campaigns.campaign import Campaign
from hannes.campaigns.check import check, refuse_faults
from hannes.campaigns.mixed_runs import mixed_runs, several_units
from hannes.campaigns.quality.finding import Finding, warning
from hannes.campaigns.shared_findings import with_shared_as_warnings
from hannes.plants.part_fault import moves_by_run

SUPPLY = "supply"
FEWEST_FALLING = 4  # recordings of which a fall is seen
FALL, CLEAR = 0.02, 3.0  # of the mean, and standard deviations about a line


def campaign_warnings(campaign: Campaign) -> list[str]:
    """One line for each kind of warning; BadInput where the data check finds a fault.

    A fault (a wrong unit, a reversed sign, a dead channel) would be named as an effect.
    """
    found = with_shared_as_warnings(
        campaign, [(each.name, check(each.recording, campaign.plant)) for each in campaign.entries]
    )
    across = across_runs(campaign)
    refuse_faults([*found, ("the campaign", across)])
    kinds: dict[tuple[str, str], list[tuple[str, Finding]]] = {}
    for name, findings in found:
        for each in findings:
            if each.level == "warning":
                kinds.setdefault((each.kind, each.channel), []).append((name, each))
    lines = [_line(group, len(found)) for group in kinds.values()]
    return [*lines, *map(str, (*several_units(campaign), *across))]


def across_runs(campaign: Campaign) -> list[Finding]:
    """What only several recordings show: two machines mixed, copies, a supply that falls."""
    return [*mixed_runs(campaign), *_copies(campaign), *_supply(campaign)]


def _copies(campaign: Campaign) -> Iterator[Finding]:
    """Recordings with the same readings to the bit, which two runs never have."""
    first: dict[bytes, str] = {}
    for each in campaign.entries:
        judged = [name for name in campaign.plant.judged if name in each.recording]
        readings = b"".join(each.recording[name].tobytes() for name in judged)
        before = first.setdefault(readings, each.name)
        if before != each.name:
            yield warning(
                "copy",
                judged[0],
                f"{each.name} has the same readings as {before}: a copy says nothing of how runs "
                "differ; leave it out",
            )


def _how(campaign: Campaign) -> str:
    """What else may be done, of a machine whose diagnosis knows a supply that falls."""
    known = any(moves_by_run(each) for each in campaign.effects.values())
    return "; `hannes diagnose` tries such a supply" if known else ", or use the first runs apart"


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
        "down, and later runs are slower; charge it between runs" + _how(campaign),
        size=fall,
    )


def _line(found: Sequence[tuple[str, Finding]], count: int) -> str:
    name, first = found[0]
    where = "" if len(found) == 1 else f"{len(found)} of {count} recordings, such as "
    return f"{where}{name}: {first}"
