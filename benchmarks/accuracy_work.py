"""Accuracy against work: error of a dynamometer grasp over its whole trace, and solver time.

Every method runs at several tolerances in turn, repeated; errors are the worst and RMS over
the trace, relative to its peak, against LSODA at rtol 1e-10.
"""

import statistics
from typing import Any

import numpy as np

from benchmarks.harness import Row, main, must_show
from hannes.hand import Hand
from hannes.simulate import simulate
from hannes.spec import load_experiment
from hannes.trajectory import Trajectory

TRACES = ("current", "force", "leader_tension")
CASES = [
    (method, rtol) for method in ("LSODA", "BDF", "Radau", "RK45") for rtol in (1e-3, 1e-4, 1e-5)
]


def errors(run: Trajectory, reference: Trajectory) -> dict[str, float]:
    """Worst and RMS error of each trace [% of the reference's peak]."""
    found = {}
    for name in TRACES:
        off = (run[name] - reference[name]) / np.abs(reference[name]).max()
        found[f"{name}_worst_%"] = float(100 * np.abs(off).max())
        found[f"{name}_rms_%"] = float(100 * np.sqrt(np.mean(off**2)))
    return found


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Time every case; milliseconds are medians, spread is the range over repeats."""
    hand, experiment = Hand(), load_experiment("dynamometer")[0].experiment
    reference = simulate(hand, experiment, rtol=1e-10)
    seconds: dict[Any, list[float]] = {case: [] for case in CASES}
    runs: dict[Any, Trajectory] = {}
    for _ in range(2 if quick else 9):
        for method, rtol in CASES:
            runs[method, rtol] = simulate(hand, experiment, method=method, rtol=rtol)
            seconds[method, rtol].append(1e3 * runs[method, rtol].cost.seconds)
    rows = [
        {
            "method": method,
            "rtol": f"{rtol:g}",
            "ms": statistics.median(seconds[method, rtol]),
            "spread_ms": max(seconds[method, rtol]) - min(seconds[method, rtol]),
            "evaluations": runs[method, rtol].cost.evaluations,
            **errors(runs[method, rtol], reference),
        }
        for method, rtol in CASES
    ]
    grasp = statistics.median(seconds["LSODA", 1e-4])
    bound = must_show("dynamometer grasp, LSODA at rtol 1e-4 [ms]", grasp, 30.0, grasp <= 30.0)
    return rows, [bound]


if __name__ == "__main__":
    main(__doc__, "accuracy_work", measure)
