"""The working covariance of one run, D + U U', and the square root of its inverse."""

from dataclasses import dataclass

import numpy as np

NEGLIGIBLE = 1e-6  # of the largest direction, or of the noise: below that it counts for nothing
FEW = 64  # directions up to which their SVD costs little


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
        sizes, basis = _orthogonal(directions / noise)
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


def _orthogonal(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sizes and unit vectors of orthogonal directions with the same covariance; (k,), (k, n).

    Of many by their Gram matrix: that is a hundred times as fast as their SVD.
    """
    if len(rows) <= FEW:
        _, sizes, basis = np.linalg.svd(rows, full_matrices=False)
        return sizes, basis
    squares, vectors = np.linalg.eigh(rows @ rows.T)
    sizes = np.sqrt(np.maximum(squares, 0.0))
    seen = sizes > NEGLIGIBLE * max(1.0, float(sizes.max()))
    return sizes[seen], (vectors[:, seen].T @ rows) / sizes[seen][:, np.newaxis]
