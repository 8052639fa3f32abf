"""Intervals by run: the spread of the runs' influences, corrected for the bias of few runs.

Whitened, every run r has a Jacobian X_r and a residual z_r. G_r = X_r' X_r, M = (sum G_r +
prior)^-1, and u_r = M X_r' z_r is its influence on the parameters. At the fit the influences sum
to zero, so the sum of their squares is less than the variance, the more so the fewer runs decide a
parameter. If the working covariance is right, the influences have covariance B (runs x runs,
known from the G_r). The sum of squares times trace(M G M) / trace(B) is then unbiased, with
trace(B)^2 / trace(B^2) degrees of freedom (Satterthwaite 1946; Bell & McCaffrey 2002).

The runs of one condition may influence a parameter more than those of another, against
expectation. B is scaled accordingly, with shrinkage, because few runs determine that. Without it
runs that only seem to decide would leave too few degrees of freedom. With too little shrinkage
three runs that happen to agree would narrow an interval twice.
"""

from dataclasses import dataclass

import numpy as np

from hannes.identification.calibration.least_squares import weights
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.tuning import CALIBRATION


@dataclass(frozen=True)
class Spread:
    """Of all parameters, scaled; shapes (p,) unless stated otherwise.

    deviation:  standard deviation, by run;  freedom: its degrees of freedom
    reach:      half-width of the 95 % interval
    working:    standard deviation if the working covariance is right;  covariance: (p, p)
    textbook:   standard deviation by the usual formula, s^2 (J'J)^-1
    alone:      where one run alone decides, so that only the working covariance counts
    influences: of every cluster on every parameter, shape (clusters, p)
    unit:       what a cluster is, in words
    """

    deviation: np.ndarray
    freedom: np.ndarray
    reach: np.ndarray
    working: np.ndarray
    covariance: np.ndarray
    textbook: np.ndarray
    alone: np.ndarray
    influences: np.ndarray
    unit: str


def spread(found: State) -> Spread:
    """Intervals of a finished search."""
    from scipy.stats import norm, t

    count = len(found.plan.names)
    information, scores, conditions, unit = _clusters(found)
    prior = np.concatenate([found.scales.prior, np.ones(len(found.plan.uncertain))]) ** 2
    inverse = np.linalg.inv(information.sum(axis=0) + np.diag(prior))
    influences = (scores @ inverse)[:, :count]
    influences = influences - influences.mean(axis=0)  # the priors hold against their sum
    heterogeneity = _heterogeneity(information, inverse, influences, conditions)
    bias_factor, freedom = _correction(information, inverse, heterogeneity)
    by_run = np.sqrt(bias_factor * (influences**2).sum(axis=0))
    by_prior = np.sqrt(np.einsum("ij,j,ij->i", inverse, prior, inverse)[:count])
    working = np.sqrt(np.diag(inverse)[:count])
    alone = freedom < CALIBRATION.least_freedom
    by_run = np.where(alone, np.sqrt(np.maximum(working**2 - by_prior**2, 0.0)), by_run)
    freedom = np.where(alone, np.inf, freedom)
    level = 0.5 + CALIBRATION.level / 2.0
    return Spread(
        np.hypot(by_run, by_prior),
        freedom,
        np.hypot(t.ppf(level, freedom) * by_run, norm.ppf(level) * by_prior),
        working,
        inverse[:count, :count],
        _textbook(found),
        alone,
        influences,
        unit,
    )


def _heterogeneity(
    information: np.ndarray, inverse: np.ndarray, influences: np.ndarray, conditions: np.ndarray
) -> np.ndarray:
    """Squared influences over their expectation, by condition, shape (clusters, p)."""
    rows_of_interest = inverse[: influences.shape[1]]
    expected = np.maximum(
        np.einsum("ki,rij,kj->rk", rows_of_interest, information, rows_of_interest), 1e-300
    )
    overall = (influences**2).sum(axis=0) / expected.sum(axis=0)
    heterogeneity = np.empty_like(influences)
    for condition in np.unique(conditions):
        inside = conditions == condition
        own = (influences[inside] ** 2).sum(axis=0) / expected[inside].sum(axis=0)
        heterogeneity[inside] = (inside.sum() * own + CALIBRATION.shrinkage * overall) / (
            inside.sum() + CALIBRATION.shrinkage
        )
    return heterogeneity


def _correction(
    information: np.ndarray, inverse: np.ndarray, heterogeneity: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Factor on the sum of squared influences, and its degrees of freedom, shape (count,) each."""
    count = heterogeneity.shape[1]
    bias_factor, freedom = np.ones(count), np.zeros(count)
    for place in range(count):
        factor = heterogeneity[:, place]
        whole = inverse @ np.tensordot(factor, information, 1) @ inverse
        rows = information @ inverse[place]  # G_r m, (clusters, p)
        crossed = factor[:, np.newaxis] * rows @ inverse @ rows.T
        expected = rows @ whole @ rows.T - crossed - crossed.T
        expected += np.diag(factor * (rows @ inverse[place]))
        trace, total = float(np.trace(expected)), float(whole[place, place])
        if trace > 1e-12 * max(total, 1e-300):  # else no run speaks of it at all
            bias_factor[place] = total / trace
            freedom[place] = trace**2 / float(np.sum(expected**2))
    return bias_factor, freedom


def _clusters(found: State) -> tuple[np.ndarray, np.ndarray, np.ndarray, str]:
    """Information (clusters, p, p) and scores (clusters, p) of each run, or of its segments.

    Then the condition of each cluster, and what the clusters are. p includes the uncertain
    parameters, after those of the plan.
    """
    information, scores, conditions = [], [], []
    views, everything = found.model.views, found.whitened_residuals()
    runs = zip(
        found.whitenings, found.columns, found.uncertain_columns, everything, views, strict=True
    )
    for white, columns, uncertain_columns, left, view in runs:
        rows = white(np.vstack([columns, uncertain_columns]))
        weight = weights(found.plan.loss, left)
        groups = [np.ones(left.size, bool)]
        if len(views) == 1:
            groups = [view.block == number for number in np.unique(view.block)]
        for inside in groups:
            part, heavy = rows[:, inside], weight[inside]
            information.append((part * heavy) @ part.T)
            scores.append((part * heavy) @ left[inside])
            conditions.append(view.entry.condition)
    unit = "runs" if len(views) > 1 else "segments of one run"
    return np.array(information), np.array(scores), np.array(conditions), unit


def _textbook(found: State) -> np.ndarray:
    """Root of the diagonal of s^2 (J'J)^-1, every bin taken as independent."""
    runs = list(zip(found.columns, found.residuals, found.whitenings, strict=True))
    rows = np.hstack([columns / white.noise for columns, _, white in runs])
    left = np.concatenate([residual / white.noise for _, residual, white in runs])
    square = float(left @ left) / max(1, left.size - rows.shape[0])
    information = rows @ rows.T + np.diag(found.scales.prior**2) * 1e-6
    return np.sqrt(square * np.diag(np.linalg.inv(information)))
