"""What the sampled controller adds to a run, beside the quick simulation of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class DiscretisationError:
    """What the sampled controller adds to a group's run.

    mean: shape (n,), the systematic part
    deviations: shape (samples, n), of each run from that mean, as any run may deviate: friction
                keeps them as long as the machine moves one way
    roughness: of each channel's samples
    """

    mean: np.ndarray
    deviations: np.ndarray
    roughness: dict[str, float]


@dataclass(frozen=True)
class SamplingCorrection:
    """What the controller's sampling does to a group's run, at sizes of one effect.

    sizes: of its amplitude, shape (k,), in its steps;  rows: shape (k, n)
    """

    sizes: np.ndarray
    rows: np.ndarray

    def at(self, sizes: np.ndarray) -> np.ndarray:
        """Interpolated at sizes of shape (m,), constant beyond the last, shape (m, n)."""
        at = np.interp(sizes, self.sizes, np.arange(self.sizes.size))
        low = np.floor(at).astype(int)
        high = np.minimum(low + 1, self.sizes.size - 1)
        share = (at - low)[:, np.newaxis]
        return (1.0 - share) * self.rows[low] + share * self.rows[high]

    @staticmethod
    def of(
        place: int, tried: Sequence[tuple[int, float]], rows: np.ndarray
    ) -> "SamplingCorrection":
        """Of the effect at a place; rows: of none, and of each place and size tried."""
        known = [(0.0, np.nan_to_num(rows[0]))]  # all are unknown where the run without it fails
        for (at, size), row in zip(tried, rows[1:], strict=True):
            if at == place and np.isfinite(row).all():
                known.append((size, row))
        known.sort(key=lambda each: each[0])
        return SamplingCorrection(
            np.array([size for size, _ in known]), np.array([row for _, row in known])
        )
