"""Accuracy against work: error of a dynamometer grasp over its whole trace, and solver time.

Every method runs at several tolerances in turn, repeated; errors are the worst and RMS over
the trace, relative to its peak, against Radau at rtol 1e-9. `loop` is Rodas without scipy: the
compiled steps alone, sampled like the others.
"""

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.harness import Row, main, must_show
from hannes.experiment import Experiment
from hannes.hand import Hand
from hannes.rodas.step import WORK
from hannes.simulate import LONGEST, RUN, simulate
from hannes.spec import load_experiment
from hannes.trajectory import Trajectory

TRACES = ("current", "force", "leader_tension")
FAST = tuple(("Rodas", rtol) for rtol in (1e-2, 5e-3, 2e-3, 1e-3, 3e-4, 1e-4, 1e-5))
STOCK = tuple(
    (method, rtol) for method in ("LSODA", "BDF", "Radau", "RK45") for rtol in (1e-3, 1e-4, 1e-5)
)


def errors(run: Trajectory, reference: Trajectory) -> dict[str, float]:
    """Worst and RMS error of each trace [% of the reference's peak]."""
    found = {}
    for name in TRACES:
        off = (run[name] - reference[name]) / np.abs(reference[name]).max()
        found[f"{name}_worst_%"] = float(100 * np.abs(off).max())
        found[f"{name}_rms_%"] = float(100 * np.sqrt(np.mean(off**2)))
    return found


def loop(hand: Hand, experiment: Experiment, rtol: float) -> Callable[[], np.ndarray]:
    """The same grasp by the compiled steps alone: a function that returns the sampled states."""
    posed = hand.with_values(experiment.overrides())
    compiled, reference = posed.compiled(), experiment.reference
    problem = compiled.problem(posed.vector(experiment.shape), reference.knots, np.zeros(7))
    ends = [end for _, end, _ in reference.segments(experiment.duration)]
    slots = compiled.states.slots
    atol = np.array([s.tolerance for s in slots for _ in range(s.size)]) * rtol / 1e-4
    rest, times = posed.rest(compiled), experiment.times
    rows, work = np.zeros((times.size, rest.size)), np.zeros((WORK, rest.size))
    steps, pieces, counts = np.zeros(RUN + 1), np.zeros((RUN, 4, rest.size)), np.zeros(5, np.int64)

    def run() -> np.ndarray:
        y, start = rest.copy(), 0.0
        for end in ends:
            clock = np.array([start, 0.0, end, LONGEST, 1.0])
            given = (problem.data, y, rtol, atol, clock, counts)
            problem.first_step(*given, work)
            while clock[0] != end:
                taken = problem.advance(*given, steps, pieces, work)
                part = slice(*np.searchsorted(times, (steps[0], steps[taken]), "right"))
                problem.sample(times[part], steps[: taken + 1], pieces[:taken], rows[part])
            start = end
        return rows

    return run


def timed(cases: dict[Any, Callable[[], Any]], repeats: int) -> dict[Any, list[float]]:
    """Milliseconds of each case, all cases in turn, repeated."""
    seconds: dict[Any, list[float]] = {case: [] for case in cases}
    for _ in range(repeats):
        for case, run in cases.items():
            clock = time.perf_counter()
            run()
            seconds[case].append(1e3 * (time.perf_counter() - clock))
    return seconds


def at_error(rows: list[Row], error: float, trace: str = "current_worst_%") -> float:
    """Milliseconds that a method takes for an error [%], between its cases."""
    found = sorted((row[trace], row["ms"]) for row in rows)
    return float(np.exp(np.interp(np.log(error), *np.log(np.array(found)).T)))


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Time every case; milliseconds are medians, spread is the range over repeats."""
    hand, experiment = Hand(), load_experiment("dynamometer")[0].experiment
    exact = simulate(hand, experiment, method="Radau", rtol=1e-9).require()
    repeats = 3 if quick else 15
    loops = {("loop", rtol): loop(hand, experiment, rtol) for _, rtol in FAST}
    runs: dict[Any, Trajectory] = {}

    def solver(case: tuple[str, float]) -> Callable[[], None]:
        def run() -> None:
            runs[case] = simulate(hand, experiment, method=case[0], rtol=case[1]).require()

        return run

    cases = {case: solver(case) for case in (*FAST, *STOCK)}
    timed({**loops, **cases}, 1)  # compiled now
    spent = timed({**loops, **{case: cases[case] for case in FAST}}, 10 * repeats)
    spent |= timed({case: cases[case] for case in STOCK}, repeats)
    rows = [
        {
            "method": method,
            "rtol": f"{rtol:g}",
            "ms": statistics.median(spent[method, rtol]),
            "spread_ms": max(spent[method, rtol]) - min(spent[method, rtol]),
            "loop_ms": statistics.median(spent.get(("loop", rtol), [np.nan]))
            if method == "Rodas"
            else float("nan"),
            "evaluations": runs[method, rtol].cost.evaluations,
            "jacobians": int(runs[method, rtol].cost.jacobians),
            **errors(runs[method, rtol], exact),
        }
        for method, rtol in (*FAST, *STOCK)
    ]
    return rows, _bounds(rows)


def _bounds(rows: list[Row]) -> list[Row]:
    fast = [row for row in rows if row["method"] == "Rodas"]
    slower = max(row["ms"] / row["loop_ms"] for row in fast)
    per_error = [
        row["ms"] / at_error(fast, max(row["current_worst_%"], fast[-1]["current_worst_%"]))
        for row in rows
        if row["method"] != "Rodas"
    ]
    gain = min(per_error)
    return [
        must_show(
            "simulate by Rodas over the compiled loop, largest ratio", slower, 1.5, slower <= 1.5
        ),
        must_show(
            "stock method over Rodas at equal worst error in current", gain, 10.0, gain >= 10
        ),
    ]


if __name__ == "__main__":
    main(__doc__, "accuracy_work", measure)
