"""Whether a likelihood of the true model parts two fingers that may have the same fault.

    chi2 = min over s of d' C^-1 d,   d = v(true fault) - v(the other finger's, of sizes s)

v: a campaign as the oracle's vector, of the same hand on the same noise; C: what the oracle expects
of campaigns, from scatter of hands, joints and runs and from noise. The other finger's fault may be
at both joints, as the library's is: changes of the two are added. Between sizes that are simulated
changes follow cubic splines. What is left so of the true finger itself is subtracted: the rounding
of sensors, which no two simulations share, and what splines do not follow.
"""

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from benchmarks import truth
from benchmarks.guarding.plan import SPREAD
from benchmarks.oracle.bench import Bench
from benchmarks.oracle.expected_covariance import expected
from benchmarks.oracle.features import vector
from benchmarks.oracle.store import Store, digest
from benchmarks.truth.campaign import make
from benchmarks.truth.faults import RANGES, Fault
from hannes.core.errors import ComputationFailed

KEPT = Path("results/benchmarks/oracle")
PARTED = 12.0  # chi-squared from which they are
NODES = 10  # sizes that are simulated, log-uniform from a tenth of the range's low end
LEAST_SHARE = 0.1
JOINTS = ("mcp", "pip")
STARTS = 6  # of the search, for each joint


def parted(protocol: str, seed: int, true: Fault, fingers: Sequence[str]) -> dict[str, float]:
    """Finger -> chi-squared by which it is parted from the true one, in the case's own hand."""
    bench, covariance = _bench(protocol)
    still = _vector(bench, seed, None)
    wanted = _vector(bench, seed, true) - still

    def left(finger: str) -> float:
        tables = [_table(bench, seed, true, finger, joint, still) for joint in JOINTS]
        return least(wanted, tables, covariance)

    own = left(true.finger)
    return {finger: max(0.0, left(finger) - own) for finger in fingers}


def least(
    wanted: np.ndarray,
    tables: Sequence[tuple[np.ndarray, np.ndarray]],
    factor: tuple[np.ndarray, bool],
) -> float:
    """The least chi-squared over sizes; tables: of each joint sizes (k,) and changes (k, n)."""

    curves = [CubicSpline(np.arange(len(sizes)), rows) for sizes, rows in tables]

    def chi2(x: np.ndarray) -> float:
        left = wanted - sum(curve(at) for curve, at in zip(curves, x, strict=True))
        return float(left @ cho_solve(factor, left))

    bounds = [(0.0, len(sizes) - 1.0) for sizes, _ in tables]
    starts = [
        np.array([a, b])
        for a in np.linspace(*bounds[0], STARTS)
        for b in np.linspace(*bounds[1], STARTS)
    ]
    first = min(starts, key=chi2)
    return float(minimize(chi2, first, method="Nelder-Mead", bounds=bounds).fun)


def _table(
    bench: Bench, seed: int, true: Fault, finger: str, joint: str, still: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sizes of a fault of another finger's joint, from none on, and what each changes."""
    low, high = sorted(RANGES[true.kind], key=abs)
    sizes, rows = [0.0], [np.zeros_like(still)]
    for size in np.geomspace(LEAST_SHARE * low, high, NODES):
        try:
            rows.append(_vector(bench, seed, Fault(true.kind, finger, joint, float(size))) - still)
        except ComputationFailed:
            break
        sizes.append(float(size))
    while len(rows) < 2:
        sizes, rows = [*sizes, sizes[-1]], [*rows, rows[-1]]
    return np.array(sizes), np.array(rows)


def _vector(bench: Bench, seed: int, fault: Fault | None) -> np.ndarray:
    return vector(make(bench.whole, seed, {}, SPREAD, fault=fault), bench.whole)


@cache
def _bench(protocol: str) -> tuple[Bench, tuple[np.ndarray, bool]]:
    """Of a protocol, a minute or some to simulate; kept on disk."""
    store = Store(KEPT / digest(Path(truth.__file__).parent))
    bench = Bench(protocol, store, SPREAD)
    return bench, cho_factor(expected(bench, SPREAD))
