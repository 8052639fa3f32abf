"""The best linear test for an effect whose signature is known.

    score = w . (x - mean),   w ~ C^-1 s,  scaled to w . s = 1,   C = (1 - a) S + a T

s: signature, the mean change that the effect makes; S: covariance of empty campaigns; T: what is
expected of it (see `likeness`); a: the shrinkage under which scores of empties, other than those
in S, spread least. Half of the empties give S, the other half are scored, and the other way round.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

SHRINKAGES = (0.02, 0.1, 0.3, 0.6, 0.9, 1.0)
FALSE_ALARM, POWER = 0.05, 0.80


@dataclass(frozen=True)
class Side:
    """Empties that may be looked at, and the rest: scored, never looked at.

    solvers: for each shrinkage, C factorised with one half of `seen`, with the other, and with all.
    """

    seen: np.ndarray
    scored: np.ndarray
    solvers: tuple[tuple, ...]

    def weights(self, signature: np.ndarray) -> np.ndarray:
        """w, under the shrinkage that does best within `seen`."""
        best = min(self.solvers, key=lambda solver: self._spread(solver, signature))
        return _scaled(best[2], signature)

    def _spread(self, solver: tuple, signature: np.ndarray) -> float:
        halves = self.seen[0::2], self.seen[1::2]
        return float(
            sum(
                np.std(other @ _scaled(half, signature))
                for half, other in zip(solver, reversed(halves), strict=False)
            )
        )


class Discriminant:
    """Tests of one protocol, an effect at a time."""

    def __init__(self, empties: np.ndarray, expected: np.ndarray) -> None:
        """empties: (campaigns, n); expected: (n, n)."""
        self._scale = np.sqrt(np.diag(expected))
        scaled, target = empties / self._scale, expected / np.outer(self._scale, self._scale)
        one, other = scaled[0::2], scaled[1::2]
        self._sides = (_side(one, other, target), _side(other, one, target))

    def scores(self, signature: np.ndarray, change: np.ndarray) -> tuple[np.ndarray, float]:
        """Scores of empties never looked at, (empties,), and the mean score of changes, (hands, n).

        Both are of the signature's size 1.
        """
        weights = [side.weights(signature / self._scale) for side in self._sides]
        empty = [
            (side.scored - side.seen.mean(axis=0)) @ w
            for side, w in zip(self._sides, weights, strict=True)
        ]
        scores = (change / self._scale) @ np.mean(weights, axis=0)
        return np.concatenate(empty), float(scores.mean())


def power(empty: np.ndarray, change: float) -> float:
    """Share of campaigns above the null's quantile that an effect lifts by `change`."""
    return float(np.mean(empty + change > np.quantile(empty, 1.0 - FALSE_ALARM)))


def needed(empty: np.ndarray, change: float) -> float:
    """How many times `change` it takes for `POWER`; inf where it points the other way."""
    low, high = np.quantile(empty, [1.0 - POWER, 1.0 - FALSE_ALARM])
    return float((high - low) / change) if change > 0.0 else np.inf


def _side(seen: np.ndarray, scored: np.ndarray, target: np.ndarray) -> Side:
    parts = (seen[0::2], seen[1::2], seen)
    solvers = tuple(
        tuple(cho_factor((1.0 - a) * np.cov(part, rowvar=False) + a * target) for part in parts)
        for a in SHRINKAGES
    )
    return Side(seen, scored, solvers)


def _scaled(factor: tuple, signature: np.ndarray) -> np.ndarray:
    weights = cho_solve(factor, signature)
    return weights / (weights @ signature)
