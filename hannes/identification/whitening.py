"""The working covariance of one run, D + U U', and the square root of its inverse."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Whitening:
    """Whitens a run's residual if the working covariance is right.

    noise:      standard deviations, the root of D, shape (n,)
    directions: run-to-run variability, scaled: U', shape (k, n)
    """

    noise: np.ndarray
    directions: np.ndarray
    basis: np.ndarray
    shrink: np.ndarray

    @classmethod
    def of(cls, noise: np.ndarray, directions: np.ndarray) -> "Whitening":
        """Whitening for these."""
        _, sizes, basis = np.linalg.svd(directions / noise, full_matrices=False)
        return cls(noise, directions, basis, 1.0 - 1.0 / np.sqrt(1.0 + sizes**2))

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """Rows of shape (..., n), whitened."""
        scaled = rows / self.noise
        return scaled - ((scaled @ self.basis.T) * self.shrink) @ self.basis

    def attributed(self, residual: np.ndarray) -> np.ndarray:
        """Most likely run-to-run deviation along each direction, in standard deviations, (k,).

        `residual` is measured minus simulated, shape (n,).
        """
        return self.directions @ self._inverse(residual)

    def rest(self, residual: np.ndarray) -> np.ndarray:
        """What is left of `residual` once that is subtracted, shape (n,)."""
        return self.noise**2 * self._inverse(residual)

    def _inverse(self, residual: np.ndarray) -> np.ndarray:
        white = residual / self.noise
        kept = (1.0 - self.shrink) ** 2 - 1.0
        return (white + ((white @ self.basis.T) * kept) @ self.basis) / self.noise
