"""How much of each channel counts as noise: the model error assumed, or the residual."""

from collections.abc import Sequence

import numpy as np

from hannes.identification.binned_run import View
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.simulator import Model
from hannes.plants.protocol import expectations


def sizes(model: Model) -> np.ndarray:
    """RMS of every channel and feature over all runs [its unit], shape (names,).

    Of a channel that follows a command, only its deviation from that: a controlled position by
    itself carries little information.
    """
    follows = {name: each.follows for name, each in expectations(model.plant).items()}
    names = model.views[0].names
    return np.array([_size(model.views, name, follows.get(name, "")) for name in names])


def _size(views: Sequence[View], name: str, command: str) -> float:
    values = []
    for view in views:
        off = {**view.recording.channels}
        if name in view.channels and command in view.recording:
            off[name] = off[name] - view.recording[command]
        values.append(view.of(off)[view.part == view.names.index(name)])
    whole = np.concatenate(values)
    return float(np.sqrt(np.mean(whole**2))) if whole.size else 0.0


def first(least: np.ndarray, noise_floors: np.ndarray) -> np.ndarray:
    """Noise before any fit: the spread of repeats, or the least that is assumed, (names,)."""
    return _above_zero(np.maximum(least, noise_floors))


def remaining(state: State, least: np.ndarray, noise_floors: np.ndarray) -> np.ndarray:
    """Noise after a fit: its residual less run-to-run variability, or the least that is assumed.

    Features keep their noise floor from repeats: there are too few of them to estimate it.
    """
    level = least.copy()
    runs = zip(state.whitenings, state.residuals, strict=True)
    rests = [white.rest(residual) for white, residual in runs]
    for number, name in enumerate(state.model.views[0].names):
        pairs = zip(rests, state.model.views, strict=True)
        left = np.concatenate([rest[view.part == number] for rest, view in pairs])
        if name not in state.plan.channels:
            level[number] = max(level[number], noise_floors[number])
        elif left.size:
            level[number] = max(level[number], float(np.sqrt(np.mean(left**2))))
    return _above_zero(level)


def _above_zero(level: np.ndarray) -> np.ndarray:
    """A channel in which nothing happens has no weight, whatever the number."""
    return np.where(level > 0.0, level, 1.0)
