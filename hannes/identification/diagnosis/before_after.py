"""What complete simulations, sampled controller included, leave of recordings, in SI units."""

from collections.abc import Sequence

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.campaigns.segments import Segment
from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.repeat_groups import Channels, Group, grouped, one_by_one
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.residuals import Raw, Traces

STAGES = ("as_given", "before", "after")


def simulated(
    model: Model, entries: Sequence[Entry], places: np.ndarray, as_given: int = 0
) -> list[list[Channels | None]]:
    """Channels of each recording at each of the points x, (stages, size); None where it fails.

    as_given: how many of the first points are of the stated machine, of which no part is off.
    Raises ComputationFailed where the first fails, the machine as given.
    """
    found: dict[int, list[Channels | None]] = {}
    by_run = bool(places[:, model.space.by_run].any())
    groups = grouped(model.small, entries)
    for group in one_by_one(groups) if by_run else groups:
        made = _stages(model, group, places, as_given)
        if made[0] is None:
            raise ComputationFailed(f"{group.entries[0].name} cannot be simulated as given")
        found.update({id(entry): made for entry in group.entries})
    return [found[id(entry)] for entry in entries]


def _stages(model: Model, group: Group, places: np.ndarray, as_given: int) -> list[Channels | None]:
    if not model.parts_at or not as_given:
        return model.simulated(group, places, True, exact=True)
    given = model.with_parts_at({})
    return [
        *given.simulated(group, places[:as_given], True, exact=True),
        *model.simulated(group, places[as_given:], True, exact=True),
    ]


def left(segments: Sequence[Segment], runs: Sequence[Channels], names: Sequence[str]) -> Raw:
    """Simulated minus recorded of each segment and channel, over its counted samples."""
    return [
        {
            name: (run[name] - segment.recording[name])[segment.mask]
            for name in names
            if name in segment.recording
        }
        for segment, run in zip(segments, runs, strict=True)
    ]


def traced(segment: Segment, runs: Sequence[Channels], names: Sequence[str]) -> Traces:
    """One recording and its simulations of the three stages."""
    recording = segment.entry.recording
    there = [name for name in names if name in recording]
    measured = {name: recording[name] for name in there}
    stages = ({name: np.asarray(run[name]) for name in there} for run in runs)
    return Traces(segment.entry, recording.time, segment.mask, measured, *stages)
