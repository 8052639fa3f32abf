"""Estimates of the force over time, beside the truth: observer, forests, look-up, analytic.

Look-up and analytic estimate are given what they need from grasps with known force: those of the
data set that trained the forests.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from hannes.dataset.read import read
from hannes.simulation.hand.hand import Hand

TOUCHED = 2.0  # N, from which an estimate is scored
GRASPS = 300  # of the data set
BINS = 40
TO_90 = 1.645 / 1.96  # from the logarithm of a 95 % interval to that of a 90 % one
METHODS = ("observer", "forests", "look-up", "analytic")


@dataclass(frozen=True)
class Known:
    """Median force [N] by current [A]; free current [A]; force for each newton in the wire."""

    currents: np.ndarray
    forces: np.ndarray
    free: float
    lever: float

    def look_up(self, current: np.ndarray) -> np.ndarray:
        """Force [N] by a table of current, as Casini et al. (2015)."""
        return np.interp(current, self.currents, self.forces)

    def analytic(self, current: np.ndarray) -> np.ndarray:
        """Force [N] from the torque above that of an empty hand, as Deng et al. (2020)."""
        return self.lever * pull(current, self.free)


def pull(current: np.ndarray, free: float) -> np.ndarray:
    """Tension in the leader wire above that of an empty hand [N]: k_t (i - i_free) N / r_p."""
    values = Hand().parameters
    torque = values["motor.torque_constant"] * np.maximum(current - free, 0.0)
    return torque * values["gear.ratio"] / values["gear.pulley_radius"]


@cache
def known(path: str) -> Known:
    """What grasps of a data set say."""
    data = read(path)
    rows = np.flatnonzero(data.usable)[:GRASPS]
    blocks = [each[:, 200::10].reshape(-1, 2) for each in data.blocks(rows, ("current", "force"))]
    return _fitted(*np.concatenate(blocks).astype(float).T)


def _fitted(current: np.ndarray, force: np.ndarray) -> Known:
    edges = np.quantile(current, np.linspace(0.0, 1.0, BINS + 1))
    place = np.clip(np.searchsorted(edges, current) - 1, 0, BINS - 1)
    some = [k for k in range(BINS) if (place == k).any()]
    free = float(np.median(current[force < 0.1]))
    on = force > TOUCHED
    tension = np.maximum(pull(current[on], free), 1e-9)
    return Known(
        np.array([np.median(current[place == k]) for k in some]),
        np.array([np.median(force[place == k]) for k in some]),
        free,
        float(np.median(force[on] / tension)),
    )


def scores(
    path: str, force: np.ndarray, current: np.ndarray, observed: np.ndarray, forest: np.ndarray
) -> dict[str, dict[str, float]]:
    """Median error [N] and share of the force, and share inside the 90 % band, by method.

    force, current: (n,); observed, forest: estimate and ends of its band (n, 3), the forest's 95 %.
    """
    on, given = force > TOUCHED, known(path)
    narrow = forest.copy()
    with np.errstate(divide="ignore", invalid="ignore"):
        for k in (1, 2):
            narrow[:, k] = forest[:, 0] * (forest[:, k] / forest[:, 0]) ** TO_90
    alone = {"look-up": given.look_up(current), "analytic": given.analytic(current)}
    found = {}
    for name in METHODS:
        band = {"observer": observed, "forests": np.nan_to_num(narrow)}.get(name)
        value = alone[name] if band is None else band[:, 0]
        off = np.abs(value - force)[on]
        found[name] = {"error": float(np.median(off)), "share": float(np.median(off / force[on]))}
        if band is not None:
            inside = (band[on, 1] <= force[on]) & (force[on] <= band[on, 2])
            found[name]["inside"] = float(inside.mean())
    return found
