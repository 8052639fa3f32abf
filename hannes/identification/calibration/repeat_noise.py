"""How much the same run differs from itself: noise floors from repeats, else from roughness."""

from collections.abc import Sequence

import numpy as np

from hannes.core.recording.white_noise import roughness
from hannes.identification.binned_run import View

REPEATS = "the spread between repeats of one condition"
ROUGH = (
    "sample-to-sample roughness, because no condition was repeated: sensor noise only, a lower "
    "bound"
)


def noise_floors(views: Sequence[View]) -> tuple[np.ndarray, str]:
    """Standard deviation of each channel's bins and of each feature [its unit], and its origin.

    Shape (names,); NaN for a feature that was never repeated. From repeats: the spread between
    runs of one condition, as RMS over time.
    """
    names = views[0].names
    spreads = np.array([_repeated(views, name, binned=True) for name in names])
    rough = np.array([_rough(views, name) for name in names])
    traced = np.isfinite(rough)
    found = np.where(np.isfinite(spreads), np.fmax(spreads, 0.0), rough)
    how = REPEATS if np.isfinite(spreads[traced]).all() else ROUGH
    return found, how


def sample_noise_floors(views: Sequence[View]) -> dict[str, float]:
    """The same of single samples instead of bins, by channel."""
    channels = dict.fromkeys(name for view in views for name in view.channels)
    found = {}
    for name in channels:
        spread = _repeated(views, name, binned=False)
        found[name] = spread if np.isfinite(spread) else _rough(views, name, binned=False)
    return found


def _repeated(views: Sequence[View], name: str, binned: bool) -> float:
    """Root mean variance between the runs of each condition; NaN where there are no repeats."""
    groups: dict[str, list[np.ndarray]] = {}
    for view in views:
        values = view.part_of(name) if binned else view.samples(name)
        if values.size:
            groups.setdefault(view.entry.condition, []).append(values)
    squares, weights = [], []
    for runs in (each for each in groups.values() if len(each) > 1):
        shortest = min(run.size for run in runs)
        variance = np.var([run[:shortest] for run in runs], axis=0, ddof=1)
        squares.append(variance.mean())
        weights.append(variance.size * (len(runs) - 1))
    return float(np.sqrt(np.average(squares, weights=weights))) if squares else np.nan


def _rough(views: Sequence[View], name: str, binned: bool = True) -> float:
    """White noise of a channel from second differences of its samples; less in bins."""
    found = []
    for view in (each for each in views if name in each.channels):
        together = len(view.recording) / view.bins if binned else 1.0
        found.append(roughness(view.recording[name]) / np.sqrt(max(1.0, together)))
    return float(np.median(found)) if found else np.nan
