"""Parameters as the search moves them: scaled, about their nominal values."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hannes.identification.calibration.settings import Plan


@dataclass
class Scales:
    """x = (value - nominal) / scale; bounds and priors of x, shapes (p,).

    `bounds` [SI], shape (p, 2): x rounds, and a value on its bound would leave it by the last bit.
    `prior` is one over the standard deviation of x before any recording.
    """

    names: tuple[str, ...]
    nominal: np.ndarray
    scale: np.ndarray
    bounds: np.ndarray
    low: np.ndarray
    high: np.ndarray
    prior: np.ndarray

    @classmethod
    def of(cls, plan: Plan, given: Mapping[str, float]) -> "Scales":
        """Scales of a plan about the nominal values."""
        at = np.array([given[name] for name in plan.names])
        scale = np.array([plan.scale[name] for name in plan.names])
        bounds = np.array([plan.bounds[name] for name in plan.names])
        low, high = (bounds - at[:, np.newaxis]).T / scale
        spread = np.array([plan.spread[name] for name in plan.names])
        return cls(plan.names, at, scale, bounds, low, high, scale / spread)

    def values(self, x: np.ndarray) -> dict[str, float]:
        """SI values by name, inside the bounds to the last bit."""
        values = np.clip(self.nominal + x * self.scale, *self.bounds.T)
        return dict(zip(self.names, values.tolist(), strict=True))
