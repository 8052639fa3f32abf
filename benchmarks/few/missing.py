"""How much of what is missing shows: beside the spread of repeats, and beyond the machine's values.

What is hidden changes the recordings; made again without it, by the same hand and the same noise,
they say how. The machine's uncertain and fitted values can follow some of that change, each within
what the settings say of it. What they cannot is all that any test could see.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.few.cases import Case
from hannes.identification.calibration.linearisation import State


def times_spread(case: Case, found: State) -> dict[str, float]:
    """Of the channel with most: the change, whole and beyond the machine's values, over the spread.

    RMS over bins and conditions; the spread is the standard deviation between repeats, likewise.
    """
    views = found.model.views
    changes = [view.measured - view.of(case.plain[view.entry.name].channels) for view in views]
    spread = [_spread(found, number) for number in range(len(views[0].names))]
    return {
        name: max(_rms(found, each, number) / spread[number] for number in range(len(spread)))
        for name, each in (("whole", changes), ("beyond", _beyond(found, changes)))
    }


def _beyond(found: State, changes: Sequence[np.ndarray]) -> list[np.ndarray]:
    """What is left of changes where fitted and uncertain values follow them best."""
    columns = [np.vstack(pair) for pair in zip(found.columns, found.uncertain_columns, strict=True)]
    rows = np.hstack([w(each) for w, each in zip(found.whitenings, columns, strict=True)])
    whole = np.concatenate([w(each) for w, each in zip(found.whitenings, changes, strict=True)])
    uncertain = len(found.uncertain_columns[0])
    prior = np.concatenate([found.scales.prior**2, np.ones(uncertain)])
    moved = np.linalg.solve(rows @ rows.T + np.diag(prior), rows @ whole)
    return [each - moved @ own for each, own in zip(changes, columns, strict=True)]


def _rms(found: State, changes: Sequence[np.ndarray], number: int) -> float:
    """Of the mean change of each condition in one channel."""
    return float(np.sqrt(np.mean([np.mean(np.mean(rows, axis=0) ** 2)
                                  for rows in _conditions(found, changes, number)])))  # fmt: skip


def _spread(found: State, number: int) -> float:
    """Standard deviation between repeats in one channel; infinite where it is not there."""
    rows = _conditions(found, [view.measured for view in found.model.views], number)
    return float(np.sqrt(np.mean([np.mean(np.var(each, axis=0, ddof=1)) for each in rows])))


def _conditions(found: State, vectors: Sequence[np.ndarray], number: int) -> list[np.ndarray]:
    """Rows of each condition in one channel, shape (runs, bins) each."""
    groups: dict[str, list[np.ndarray]] = {}
    for view, vector in zip(found.model.views, vectors, strict=True):
        if (view.part == number).any():
            groups.setdefault(view.entry.condition, []).append(vector[view.part == number])
    return [np.array(rows) for rows in groups.values()]
