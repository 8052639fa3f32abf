"""How much the same run differs from itself: floors from repeats, else from roughness."""

from collections.abc import Sequence

import numpy as np

from hannes.calibration.view import View

REPEATS = "the spread between repeats of one condition"
ROUGH = (
    "sample-to-sample roughness, because no condition was repeated: sensor noise only, a lower "
    "bound"
)


def floors(views: Sequence[View]) -> tuple[np.ndarray, str]:
    """Standard deviation of each channel's bins and of each feature [its unit], and how it was had.

    Shape (names,); NaN for a feature that was never repeated. From repeats: the spread between
    runs of one condition, as RMS over time.
    """
    names = views[0].names
    spreads = np.array([_repeated(views, number) for number in range(len(names))])
    rough = np.array([_rough(views, name) for name in names])
    traced = np.isfinite(rough)
    found = np.where(np.isfinite(spreads), np.fmax(spreads, 0.0), rough)
    how = REPEATS if np.isfinite(spreads[traced]).all() else ROUGH
    return found, how


def _repeated(views: Sequence[View], number: int) -> float:
    """Root mean variance between the runs of each condition; NaN where there are no repeats."""
    groups: dict[str, list[np.ndarray]] = {}
    for view in views:
        values = view.measured[view.part == number]
        if values.size:
            groups.setdefault(view.entry.condition, []).append(values)
    squares, weights = [], []
    for runs in (each for each in groups.values() if len(each) > 1):
        shortest = min(run.size for run in runs)
        variance = np.var([run[:shortest] for run in runs], axis=0, ddof=1)
        squares.append(variance.mean())
        weights.append(variance.size * (len(runs) - 1))
    return float(np.sqrt(np.average(squares, weights=weights))) if squares else np.nan


def _rough(views: Sequence[View], name: str) -> float:
    """White noise of a channel's bins from the second differences of its samples."""
    found = [
        1.4826 * np.median(np.abs(np.diff(view.recording[name], 2))) / np.sqrt(6.0)
        / np.sqrt(max(1.0, len(view.recording) / view.bins))
        for view in views
        if name in view.channels
    ]  # fmt: skip
    return float(np.median(found)) if found else np.nan
