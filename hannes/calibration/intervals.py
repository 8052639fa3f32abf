"""Intervals by run: the spread of the runs' own pulls, freed of the bias that few runs give it.

Whitened, every run r has slopes X_r and misfit z_r; G_r = X_r' X_r, M = (sum G_r + prior)^-1, and
u_r = M X_r' z_r is its pull on the parameters. At the fit the pulls balance, so the sum of their
squares is less than the variance, the more so the fewer runs decide a parameter. Were the working
covariance right, the pulls at the fit would have covariance B (runs x runs, known from the G_r);
then the sum of squares times trace(M G M) / trace(B) is free of bias, and it is as sure as
trace(B)^2 / trace(B^2) degrees of freedom (Satterthwaite 1946; Bell & McCaffrey 2002).
"""

from dataclasses import dataclass

import numpy as np

from hannes.calibration.search import ROBUST, Found

LEVEL = 0.95
ALONE = 1.2  # degrees of freedom below which one run alone decides a parameter


@dataclass(frozen=True)
class Spread:
    """Of all parameters, scaled; shapes (p,) unless said otherwise.

    deviation: standard deviation, by run;  freedom: its degrees of freedom
    reach:     half-width of the 95 % interval
    working:   standard deviation if the working covariance were right;  covariance: (p, p)
    textbook:  standard deviation by the usual formula, s^2 (J'J)^-1
    alone:     where one run alone decides, so that only the working covariance speaks
    pulls:     of every cluster on every parameter, shape (clusters, p)
    """

    deviation: np.ndarray
    freedom: np.ndarray
    reach: np.ndarray
    working: np.ndarray
    covariance: np.ndarray
    textbook: np.ndarray
    alone: np.ndarray
    pulls: np.ndarray
    unit: str


def spread(found: Found) -> Spread:
    """Intervals of a finished search."""
    from scipy.stats import t

    information, scores, unit = _clusters(found)
    prior = np.diag(found.scales.prior**2)
    inverse = np.linalg.inv(information.sum(axis=0) + prior)
    pulls = scores @ inverse
    pulls = pulls - pulls.mean(axis=0)  # the prior holds against their sum
    honest, freedom = _correction(information, inverse)
    deviation = np.sqrt(honest * (pulls**2).sum(axis=0) + np.diag(inverse @ prior @ inverse))
    working = np.sqrt(np.diag(inverse))
    alone = freedom < ALONE
    deviation, freedom = np.where(alone, working, deviation), np.where(alone, np.inf, freedom)
    reach = t.ppf(0.5 + LEVEL / 2.0, freedom) * deviation
    return Spread(deviation, freedom, reach, working, inverse, _textbook(found), alone, pulls, unit)


def _correction(information: np.ndarray, inverse: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Factor on the sum of squared pulls, and its degrees of freedom, shape (p,) each."""
    own = np.einsum("ij,rjk,kl->ril", inverse, information, inverse)  # M G_r M
    total = own.sum(axis=0)
    leverage = inverse @ information  # M G_r
    shared = np.einsum("rij,sjk->rsik", leverage, own)  # M G_r M G_s M
    both = np.einsum("rij,jk,slk->rsil", leverage, total, leverage)
    expected = np.einsum("rskk->krs", both) - 2.0 * np.einsum("rskk->krs", shared)
    for run in range(len(information)):
        expected[:, run, run] += np.diag(own[run])
    trace = np.einsum("krr->k", expected)
    square = np.einsum("krs,krs->k", expected, expected)
    told = trace > 1e-12 * np.maximum(np.diag(total), 1e-300)  # else no run speaks of it at all
    honest = np.divide(np.diag(total), trace, out=np.ones_like(trace), where=told)
    return honest, np.divide(trace**2, square, out=np.zeros_like(trace), where=told)


def _clusters(found: Found) -> tuple[np.ndarray, np.ndarray, str]:
    """Information (clusters, p, p) and scores (clusters, p) of each run, or of its blocks."""
    information, scores = [], []
    views = found.model.views
    runs = zip(found.whitenings, found.columns, found.misses, views, strict=True)
    for white, columns, miss, view in runs:
        rows, left = white(columns), white(miss)
        weight = weights(found.plan.loss, left)
        groups = [np.ones(left.size, bool)]
        if len(views) == 1:
            groups = [view.block == number for number in np.unique(view.block)]
        for inside in groups:
            part, heavy = rows[:, inside], weight[inside]
            information.append((part * heavy) @ part.T)
            scores.append((part * heavy) @ left[inside])
    unit = "runs" if len(views) > 1 else "stretches of one run"
    return np.array(information), np.array(scores), unit


def weights(loss: str, left: np.ndarray) -> np.ndarray:
    """What a robust loss leaves of every element's weight, shape (n,)."""
    z = (left / ROBUST) ** 2
    if loss == "soft_l1":
        return 1.0 / np.sqrt(1.0 + z)
    if loss == "huber":
        return 1.0 / np.sqrt(np.maximum(z, 1.0))
    return 1.0 / (1.0 + z) if loss == "cauchy" else np.ones_like(z)


def _textbook(found: Found) -> np.ndarray:
    """Root of the diagonal of s^2 (J'J)^-1, every bin taken as independent."""
    rows = np.hstack([c / w.noise for c, w in zip(found.columns, found.whitenings, strict=True)])
    left = np.concatenate(
        [m / w.noise for m, w in zip(found.misses, found.whitenings, strict=True)]
    )
    square = float(left @ left) / max(1, left.size - rows.shape[0])
    information = rows @ rows.T + np.diag(found.scales.prior**2) * 1e-6
    return np.sqrt(square * np.diag(np.linalg.inv(information)))
