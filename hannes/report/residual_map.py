"""Where simulation and recordings disagree: by condition and phase, channel by channel."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hannes.report.formats import number

if TYPE_CHECKING:
    from hannes.identification.residuals import Traces
    from hannes.report.diagnosed import Diagnosis

LEVELS = (1.5, 3.0, 6.0)  # noise floors, at which a cell's shade deepens
MOST_ROWS = 24  # that a page shows
FEWEST = 10  # samples of a phase whose mean is asked for
PART_OF_ALL = 0.3  # of its mean, that a constant has in each phase at least
Key = tuple[str, str]  # condition, phase


@dataclass(frozen=True)
class Cell:
    """`text` such as `5.2 → 1.1`, in noise floors; `shade` 0 to 3 by what the baseline leaves.

    `before`: what that is, in noise floors.
    """

    text: str
    shade: int
    before: float = 0.0


Row = tuple[str, str, tuple[Cell, ...]]


@dataclass(frozen=True)
class ResidualMap:
    """`rows`: condition, phase, one cell a channel; the furthest off, where there are many.

    `left_out`: how many more rows there would be.
    """

    channels: tuple[str, ...]
    rows: tuple[Row, ...]
    recordings: int
    left_out: int = 0


def residual_map(diagnosis: "Diagnosis") -> ResidualMap:
    """RMS that the refitted baseline leaves, and what is left with the effect, in noise floors."""
    channels = tuple(diagnosis.noise_floors)
    squares: dict[Key, dict[str, list[np.ndarray]]] = {}
    for traces in diagnosis.traces:
        for phase, inside in _phases(diagnosis, traces):
            cell = squares.setdefault((traces.entry.condition, phase), {})
            for name in channels:
                if name in traces.measured and inside.any():
                    cell.setdefault(name, []).append(_misses(traces, name, inside))
    named = bool(diagnosis.verdict.effects)
    rows = tuple(
        (
            condition,
            phase,
            tuple(_cell(found.get(n), diagnosis.noise_floors[n], named) for n in channels),
        )
        for (condition, phase), found in squares.items()
        if found
    )
    kept = _furthest_off(rows)
    return ResidualMap(channels, kept, len(diagnosis.traces), len(rows) - len(kept))


def _furthest_off(rows: tuple[Row, ...]) -> tuple[Row, ...]:
    """As many rows as a page shows, in their order."""
    worst = sorted(rows, key=lambda row: -max(cell.before for cell in row[2]))[:MOST_ROWS]
    return tuple(row for row in rows if row in worst)


def _phases(diagnosis: "Diagnosis", traces: "Traces") -> list[tuple[str, np.ndarray]]:
    """Samples of each phase that count, by the plant's own division."""
    phases = diagnosis.plant.phases(traces.entry.recording)
    return [(name, mask & traces.mask) for name, mask in phases.items()]


def _misses(traces: "Traces", name: str, inside: np.ndarray) -> np.ndarray:
    """Squared residuals before and after, shape (2, samples)."""
    measured = traces.measured[name][inside]
    both = [traces.before[name][inside] - measured, traces.after[name][inside] - measured]
    return np.array(both) ** 2


def _cell(parts: Sequence[np.ndarray] | None, floor: float, named: bool) -> Cell:
    if not parts:
        return Cell("–", 0)
    before, after = np.sqrt(np.concatenate(parts, axis=1).mean(axis=1)) / floor
    text = f"{number(before, 2)} → {number(after, 2)}" if named else number(before, 2)
    return Cell(text, sum(before > level for level in LEVELS), float(before))


def constant_part(diagnosis: "Diagnosis", name: str) -> float:
    """Mean residual that is left of a channel where it is most of that, and there in each phase.

    Else 0. In the channel's unit, simulated minus measured, over the recordings that are drawn.
    """
    left, phases = [], dict[str, list[np.ndarray]]()
    for traces in (each for each in diagnosis.traces if name in each.measured):
        misses = traces.after[name] - traces.measured[name]
        left.append(misses[traces.mask])
        for phase, inside in _phases(diagnosis, traces):
            phases.setdefault(phase, []).append(misses[inside])
    if not left:
        return 0.0
    every = np.concatenate(left)
    mean, size = float(every.mean()), float(np.sqrt(np.mean(every**2)))
    if abs(mean) <= max(0.5 * size, diagnosis.noise_floors[name]):
        return 0.0
    parts = [part for each in phases.values() if (part := np.concatenate(each)).size >= FEWEST]
    least = min((float(part.mean()) * np.sign(mean) for part in parts), default=abs(mean))
    return mean if least > PART_OF_ALL * abs(mean) else 0.0
