"""Pieces of recordings that have one role each, and the noise floor that repeats give."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hannes.campaigns.campaign_file import Campaign, Entry
from hannes.campaigns.periodicity import period
from hannes.campaigns.quality.subject import quantum
from hannes.core.recording.recording import Recording
from hannes.core.recording.white_noise import roughness
from hannes.plants.protocol import Plant

FEWEST_BLOCKS = 16  # a recording this long may be cut in two: one part fitted, one to choose by


@dataclass(frozen=True, eq=False)
class Piece:
    """The samples of one recording that count, in one role; `mask` has shape (n,)."""

    entry: Entry
    role: str
    mask: np.ndarray

    @property
    def recording(self) -> Recording:
        """The whole recording; simulations always run it from its start."""
        return self.entry.recording


def cut(campaign: Campaign) -> tuple[list[Piece], str]:
    """Return the pieces and a sentence on how they were cut, empty where they are recordings.

    Where no recording is left to choose by, long fitted ones give their second half for it, if
    the plant allows.
    """
    plant = campaign.plant
    pieces = [Piece(e, e.role, plant.judged_part(e.recording)) for e in campaign.entries]
    long = [piece for piece in pieces if piece.role == "fit" and _blocks(piece, plant)]
    if campaign.of("select") or not long or not halved(plant):
        return pieces, ""
    runs = {id(piece): _runs(piece, plant) for piece in long}
    made = [
        half
        for piece in pieces
        for half in (_halves(piece, runs[id(piece)]) if piece in long else [piece])
    ]
    note = (
        "no recording was left to choose by, so the second half of each fitted recording "
        "chooses, and only the first half is fitted until the choice is made"
    )
    counts = [each.size for each in runs.values() if each.size]
    if counts:
        note += f"; its command repeats, so that it was cut between two of {counts[0]} runs"
    return made, note


def halved(plant: Plant) -> bool:
    """Whether half a recording may choose: not where a diagnosis fits runs as wholes."""
    return not getattr(plant, "uncertain", {})


def _blocks(piece: Piece, plant: Plant) -> bool:
    time = piece.recording.time[piece.mask]
    return bool(time.size and time[-1] - time[0] >= FEWEST_BLOCKS * plant.block)


def _runs(piece: Piece, plant: Plant) -> np.ndarray:
    """Times at which whole runs of a repeated command begin; none where it never repeats."""
    samples, time = period(plant, piece.recording), piece.recording.time
    return time[: time.size // samples * samples : samples] if samples else np.zeros(0)


def _halves(piece: Piece, runs: np.ndarray) -> list[Piece]:
    """Both halves of a recording, cut where a run begins where there are runs."""
    time = piece.recording.time
    counted = time[piece.mask]
    middle = 0.5 * (counted[0] + counted[-1])
    inside = runs[(runs > counted[0]) & (runs < counted[-1])]
    if inside.size:
        middle = inside[np.argmin(np.abs(inside - middle))]
    early = piece.mask & (time < middle)
    return [Piece(piece.entry, "fit", early), Piece(piece.entry, "select", piece.mask & ~early)]


def of(pieces: Iterable[Piece], *roles: str) -> list[Piece]:
    """The pieces in any of these roles."""
    return [piece for piece in pieces if piece.role in roles]


def judged_channels(plant: Plant, pieces: Sequence[Piece]) -> list[str]:
    """Channels to compare that at least one recording has."""
    return [name for name in plant.judged if any(name in p.recording for p in pieces)]


def floors(plant: Plant, pieces: Sequence[Piece]) -> tuple[dict[str, float], str]:
    """Floor of each channel [its unit] and how it was had.

    From repeats: RMS over time of the standard deviation between runs under the same command, in
    several recordings or in one whose command repeats. Without repeats: white noise estimated
    from second differences and the step of quantisation, which is a lower bound.
    """
    found, methods = {}, []
    for name in judged_channels(plant, pieces):
        variances = [v for group in _repeats(plant, pieces, name) for v in group]
        again = [] if variances else _runs_within(plant, pieces, name)
        if variances or again:
            found[name] = float(np.sqrt(np.mean(variances or np.concatenate(again))))
            methods.append("repeats" if variances else "runs")
        else:
            noises = [_white_noise(p.recording[name]) for p in pieces if name in p.recording]
            found[name] = float(np.median(noises))
            methods.append("roughness")
        level = max(np.abs(p.recording[name]).max() for p in pieces if name in p.recording)
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


def _repeats(plant: Plant, pieces: Sequence[Piece], name: str) -> list[np.ndarray]:
    """Variance between runs over time, one array for each group of repeats."""
    groups: dict[tuple[str, bytes], dict[int, np.ndarray]] = {}
    for piece in pieces:
        if name in piece.recording:
            key = (piece.entry.condition, plant.same_run(piece.recording))
            groups.setdefault(key, {})[id(piece.recording)] = piece.recording[name]
    return [
        np.var(np.array(list(runs.values())), axis=0, ddof=1)
        for runs in groups.values()
        if len(runs) > 1
    ]


def _runs_within(plant: Plant, pieces: Sequence[Piece], name: str) -> list[np.ndarray]:
    """Variance between the runs of one recording over time, one array for each such recording.

    From when the plant has forgotten how it was started.
    """
    found = []
    for recording in {id(p.recording): p.recording for p in pieces if name in p.recording}.values():
        samples = period(plant, recording)
        settled = recording[name][recording.time >= recording.time[0] + plant.block]
        if samples and settled.size >= 2 * samples:
            whole = settled[: settled.size // samples * samples]
            found.append(np.var(whole.reshape(-1, samples), axis=0, ddof=1))
    return found


def _white_noise(values: np.ndarray) -> float:
    """Standard deviation of what changes from sample to sample, rounding included."""
    return max(roughness(values), quantum(values) / np.sqrt(12.0))
