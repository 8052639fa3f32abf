"""The paper's figures of one run, as far as its channels allow; NaN where one has no sense."""

from collections.abc import Callable, Mapping

import numpy as np

from hannes.simulation import grasp_metrics

Channels = Mapping[str, np.ndarray]
GRASP = ("contact", "I_avgc", "I_avgo", "I_max", "I_sc", "I_so", "F_max")
UNITS = {
    "contact": "s", "I_avgc": "A", "I_avgo": "A", "I_max": "A", "I_sc": "A/s", "I_so": "A/s",
    "F_max": "N", "void current": "A", "closing time": "s",
}  # fmt: skip


def _grasp(time: np.ndarray, channels: Channels) -> dict[str, float]:
    if not all(name in channels for name in ("current", "force", "position")):
        return {}
    found = grasp_metrics.grasp_metrics(
        time, channels["current"], channels["force"], channels["position"]
    )
    return {name: getattr(found, name) for name in GRASP}


def _void_current(time: np.ndarray, channels: Channels) -> dict[str, float]:
    if "current" not in channels or time[-1] < 0.3 or _touches(channels):
        return {}
    return {"void current": grasp_metrics.void_current(time, channels["current"])}


def _closing_time(time: np.ndarray, channels: Channels) -> dict[str, float]:
    if "position" not in channels or _touches(channels):
        return {}
    return {"closing time": grasp_metrics.closing_time(time, channels["position"])}


def _touches(channels: Channels) -> bool:
    return "force" in channels and float(channels["force"].max()) > 1.0


_MEASURES: dict[str, Callable[[np.ndarray, Channels], dict[str, float]]] = {
    **dict.fromkeys(GRASP, _grasp),
    "void current": _void_current,
    "closing time": _closing_time,
}
FEATURES = tuple(_MEASURES)


def measure(names: tuple[str, ...], time: np.ndarray, channels: Channels) -> np.ndarray:
    """Values of the features in `names`, shape (len(names),); `time` [s] from zero."""
    found: dict[str, float] = {}
    for function in dict.fromkeys(_MEASURES[name] for name in names):
        found |= function(time, channels)
    return np.array([found.get(name, np.nan) for name in names])
