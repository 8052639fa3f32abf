"""Which of several columns of stamps is the clock: the evenest, and that is said."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.begin.column_guess import Guess

FloatArray = NDArray[np.float64]

APART = 0.01  # of the span: by how much two clocks of one log may differ
ALIKE = 1e-4  # of a step: a difference of evenness that says nothing


def clock_of(
    found: Sequence[Guess], columns: Mapping[str, FloatArray]
) -> tuple[Guess | None, list[str], list[str]]:
    """The clock among guesses, what is said about the others, and what has to be asked.

    Of clocks whose names and units say all, the one with the evenest steps: arrival at a computer
    is later than sampling, by a delay that differs from sample to sample.
    """
    if not found:
        return None, [], []
    if any(each.sure for each in found):
        found = [each for each in found if each.sure]
    ranked = sorted(found, key=lambda each: _unevenness(columns.get(str(each.column))))
    best, others = ranked[0], ranked[1:]
    own = columns.get(str(best.column))
    if own is None or not others:
        return best, [], []
    said, asked = [], []
    for other in others:
        values = columns.get(str(other.column))
        said.append(_compared(best, own, other, values))
        if values is not None and _disagree(own, best.unit, values, other.unit):
            asked.append(f'which of "{best.column}", "{other.column}" is time? They disagree')
    return best, said, asked


def _unevenness(values: FloatArray | None) -> float:
    """Spread of a clock's steps over their median; infinite where it hardly goes forth."""
    if values is None:
        return 1e6  # dates as text: taken where nothing else is even
    steps = np.diff(values[np.isfinite(values)])
    if not steps.size or np.mean(steps > 0.0) < 0.5 or np.median(steps) <= 0.0:
        return np.inf
    return float(np.mean(np.abs(steps - np.median(steps))) / np.median(steps))


def _compared(best: Guess, own: FloatArray, other: Guess, values: FloatArray | None) -> str:
    mine, its = _unevenness(own), _unevenness(values)
    taken, left = f'time from "{best.column}"', f'not from "{other.column}"'
    if values is None or not np.isfinite(its):
        return f"{taken}, {left}"
    if its - mine < ALIKE:
        return f"{taken}, {left}, whose steps are as even"
    return f"{taken}, whose steps are even to {100 * mine:.2g} %, {left} ({100 * its:.2g} %)"


def _disagree(own: FloatArray, unit: str, other: FloatArray, its: str) -> bool:
    from hannes.core.io.units import unit_scale

    if not unit or not its or "counts" in (unit, its) or not np.isfinite(_unevenness(other)):
        return False
    spans = [
        float(np.nanmax(x) - np.nanmin(x)) * unit_scale(u, "s")
        for x, u in ((own, unit), (other, its))
    ]
    return abs(spans[0] - spans[1]) > APART * max(*spans, 1e-12)
