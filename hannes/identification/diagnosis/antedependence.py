"""Covariance of noise from few simulated runs: every bin is regressed on the bins before it.

A control loop keeps sums of its noise small. A covariance that is cut off over lags, or averaged
over time, loses that, and makes slow changes several times as likely as they are. Regressing each
bin on a few earlier ones keeps it (Gabriel 1962; Pourahmadi 1999). The result is never singular,
and may change along a run, as friction does.
"""

import numpy as np

from hannes.identification.diagnosis.tuning import NOISE


def covariance(deviations: np.ndarray, channels: int) -> np.ndarray:
    """Covariance, (n, n), of rows of noise, shape (m, n), channels one after another."""
    count = len(deviations)
    rows = deviations.reshape(count, channels, -1).transpose(0, 2, 1)  # run, bin, channel
    bins = rows.shape[1]
    sizes = np.sqrt(np.mean(np.square(rows), axis=(0, 1)))
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    back = max(
        1,
        min(
            NOISE.antedependence_order,
            count
            * (2 * NOISE.antedependence_window + 1)
            // (NOISE.windows_per_coefficient * channels),
        ),
    )
    rows = rows / sizes
    spread = _spread([_regressed(rows, at, back) for at in range(bins)])
    order = np.arange(bins * channels).reshape(bins, channels).T.ravel()
    scale = np.repeat(sizes, bins)
    return spread[np.ix_(order, order)] * np.outer(scale, scale)


def _regressed(rows: np.ndarray, at: int, back: int) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of one bin on earlier ones, oldest first, (channels, k); residual covariance."""
    back, bins, channels = min(back, at), rows.shape[1], rows.shape[2]
    starts = [
        at + shift
        for shift in range(-NOISE.antedependence_window, NOISE.antedependence_window + 1)
        if back <= at + shift < bins
    ]
    response = np.concatenate([rows[:, each] for each in starts])
    regressors = np.concatenate([rows[:, k - back : k].reshape(len(rows), -1) for k in starts])
    products = regressors.T @ regressors
    ridge = NOISE.ridge * np.trace(products) / max(1, len(products)) + NOISE.regression_floor
    followed = np.linalg.solve(products + ridge * np.eye(len(products)), regressors.T @ response)
    rest = response - regressors @ followed
    free = max(len(response) - regressors.shape[1], len(response) // 2)
    return followed.T, rest.T @ rest / free + NOISE.regression_floor * np.eye(channels)


def _spread(steps: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Covariance of all bins, (bins channels,) squared, bin after bin, from their regressions."""
    from scipy.linalg import cholesky, solve_triangular

    channels = len(steps[0][1])
    apart, roots = np.eye(len(steps) * channels), np.zeros((len(steps) * channels,) * 2)
    for at, (followed, rest) in enumerate(steps):
        own = slice(at * channels, (at + 1) * channels)
        apart[own, at * channels - followed.shape[1] : at * channels] = -followed
        roots[own, own] = cholesky(rest, lower=True)
    root = solve_triangular(apart, roots, lower=True, unit_diagonal=True)
    return root @ root.T
