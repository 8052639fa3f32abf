"""Segments of recordings, each in one role, and the noise floor from repeats."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.periodicity import period
from hannes.campaigns.quality.subject import quantum
from hannes.core.recording.recording import Recording
from hannes.core.recording.white_noise import roughness
from hannes.plants.protocol import Plant

FEWEST_BLOCKS_TO_SPLIT = 16  # a recording this long may be split: one half to fit, one to validate


@dataclass(frozen=True, eq=False)
class Segment:
    """The samples of one recording that are compared, in one role; `mask` has shape (n,)."""

    entry: Entry
    role: str
    mask: np.ndarray

    @property
    def recording(self) -> Recording:
        """The whole recording; simulations always run it from its start."""
        return self.entry.recording


def split_campaign(campaign: Campaign) -> tuple[list[Segment], str]:
    """Return the segments and a sentence on how they were split, empty for whole recordings.

    Where no recording has the role select, long fitted ones give their second half for it, if
    the plant allows.
    """
    plant = campaign.plant
    segments = [Segment(e, e.role, plant.judged_part(e.recording)) for e in campaign.entries]
    long = [segment for segment in segments if segment.role == "fit" and _blocks(segment, plant)]
    if campaign.of("select") or not long or not may_be_split(plant):
        return segments, ""
    runs = {id(segment): _runs(segment, plant) for segment in long}
    made = [
        half
        for segment in segments
        for half in (_halves(segment, runs[id(segment)]) if segment in long else [segment])
    ]
    note = (
        "no recording was left for validation, so the second half of each fitted recording "
        "validates, and only the first half is fitted until an effect is selected"
    )
    counts = [each.size for each in runs.values() if each.size]
    if counts:
        note += f"; its command repeats, so it was split between two of {counts[0]} runs"
    return made, note


def may_be_split(plant: Plant) -> bool:
    """Whether half a recording may validate: not where a diagnosis fits whole runs."""
    return not getattr(plant, "uncertain", {})


def _blocks(segment: Segment, plant: Plant) -> bool:
    time = segment.recording.time[segment.mask]
    return bool(time.size and time[-1] - time[0] >= FEWEST_BLOCKS_TO_SPLIT * plant.block)


def _runs(segment: Segment, plant: Plant) -> np.ndarray:
    """Times at which whole runs of a repeated command begin; none where it never repeats."""
    samples, time = period(plant, segment.recording), segment.recording.time
    return time[: time.size // samples * samples : samples] if samples else np.zeros(0)


def _halves(segment: Segment, runs: np.ndarray) -> list[Segment]:
    """Both halves of a recording, split at the start of a run where there are runs."""
    time = segment.recording.time
    counted = time[segment.mask]
    middle = 0.5 * (counted[0] + counted[-1])
    inside = runs[(runs > counted[0]) & (runs < counted[-1])]
    if inside.size:
        middle = inside[np.argmin(np.abs(inside - middle))]
    early = segment.mask & (time < middle)
    late = segment.mask & ~early
    return [Segment(segment.entry, "fit", early), Segment(segment.entry, "select", late)]


def in_roles(segments: Iterable[Segment], *roles: str) -> list[Segment]:
    """Segments in any of these roles."""
    return [segment for segment in segments if segment.role in roles]


def judged_channels(plant: Plant, segments: Sequence[Segment]) -> list[str]:
    """Channels to compare that at least one recording has."""
    return [name for name in plant.judged if any(name in s.recording for s in segments)]


def noise_floors(plant: Plant, segments: Sequence[Segment]) -> tuple[dict[str, float], str]:
    """Return the noise floor of each channel [its unit], and how it was estimated.

    With repeats: RMS over time of the standard deviation between runs under the same command.
    The runs are several recordings, or one whose command repeats. Without repeats: white noise
    from second differences and the quantisation step, which is a lower bound.
    """
    found, methods = {}, []
    for name in judged_channels(plant, segments):
        variances = [v for group in _repeats(plant, segments, name) for v in group]
        again = [] if variances else _runs_within(plant, segments, name)
        if variances or again:
            found[name] = float(np.sqrt(np.mean(variances or np.concatenate(again))))
            methods.append("repeats" if variances else "runs")
        else:
            noises = [_white_noise(s.recording[name]) for s in segments if name in s.recording]
            found[name] = float(np.median(noises))
            methods.append("roughness")
        level = max(np.abs(s.recording[name]).max() for s in segments if name in s.recording)
        found[name] = max(found[name], 1e-6 * level, 1e-15)
    how = "the spread between repeats under the same command"
    if "runs" in methods:
        how = "the spread between the runs of one recording whose command repeats"
    if "roughness" in methods:
        how = (
            "sample-to-sample roughness, because there are no repeats: sensor noise only, "
            "a lower bound"
        )
    return found, how


def _repeats(plant: Plant, segments: Sequence[Segment], name: str) -> list[np.ndarray]:
    """Variance between runs over time, one array for each group of repeats."""
    groups: dict[tuple[str, bytes], dict[int, np.ndarray]] = {}
    for segment in segments:
        if name in segment.recording:
            key = (segment.entry.condition, plant.same_run(segment.recording))
            groups.setdefault(key, {})[id(segment.recording)] = segment.recording[name]
    return [
        np.var(np.array(list(runs.values())), axis=0, ddof=1)
        for runs in groups.values()
        if len(runs) > 1
    ]


def _runs_within(plant: Plant, segments: Sequence[Segment], name: str) -> list[np.ndarray]:
    """Variance between the runs of one recording over time, one array for each such recording.

    The first `block` of the plant is left out: the initial state still matters there.
    """
    found = []
    recordings = {id(s.recording): s.recording for s in segments if name in s.recording}
    for recording in recordings.values():
        samples = period(plant, recording)
        settled = recording[name][recording.time >= recording.time[0] + plant.block]
        if samples and settled.size >= 2 * samples:
            whole = settled[: settled.size // samples * samples]
            found.append(np.var(whole.reshape(-1, samples), axis=0, ddof=1))
    return found


def _white_noise(values: np.ndarray) -> float:
    """Standard deviation of white noise, quantisation included."""
    return max(roughness(values), quantum(values) / np.sqrt(12.0))
