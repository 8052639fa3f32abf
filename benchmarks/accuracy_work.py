"""Accuracy against work: error of a dynamometer grasp over its whole trace, and solver time.

Every method runs at several tolerances in turn, repeated, on one thread, by processor time; errors
are the worst and RMS over the trace, relative to its peak, against Radau at rtol 1e-9. `alone` is
Rodas without scipy: the compiled steps, sampled like the others. The explicit methods run once:
they take seconds, as the hand is stiff.
"""

import statistics
import time
from collections.abc import Callable, Mapping
from random import Random
from typing import Any

import numpy as np
from tqdm import tqdm

from benchmarks.harness import Row, main, must_show
from hannes.simulation.compiled_call import Plan
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.integrate import Initial
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Trajectory

RESAMPLES = 400
TRACES = ("current", "force", "leader_tension")
FAST = tuple(("Rodas", rtol) for rtol in (1e-2, 5e-3, 2e-3, 1e-3, 3e-4, 1e-4, 1e-5))
STOCK = tuple(
    (method, rtol)
    for method in ("LSODA", "BDF", "Radau")
    for rtol in (1e-2, 3e-3, 1e-3, 1e-4, 1e-5)
)
# Not for stiff problems: each takes seconds.
EXPLICIT = tuple((m, rtol) for m in ("RK45", "RK23", "DOP853") for rtol in (1e-2, 1e-3, 1e-4))


def errors(run: Trajectory, reference: Trajectory) -> dict[str, float]:
    """Worst and RMS error of each trace [% of the reference's peak]."""
    found = {}
    for name in TRACES:
        off = (run[name] - reference[name]) / np.abs(reference[name]).max()
        found[f"{name}_worst_%"] = float(100 * np.abs(off).max())
        found[f"{name}_rms_%"] = float(100 * np.sqrt(np.mean(off**2)))
    return found


def alone(hand: Hand, experiment: Experiment, rtol: float) -> Callable[[], Any]:
    """The same grasp by the compiled steps alone, without scipy."""
    posed = hand.with_values(experiment.overrides())
    compiled = posed.compiled()
    plan, rest = Plan.of(compiled, experiment, rtol), posed.rest(compiled)
    vectors = posed.vector(experiment.shape)[np.newaxis]
    return lambda: plan.run(vectors, rest[np.newaxis].copy())


def by_scipy(hand: Hand, experiment: Experiment, method: str, rtol: float) -> Callable[[], Any]:
    """The grasp as `simulate` integrates it, by scipy's solve_ivp; packing is not timed."""
    posed = hand.with_values(experiment.overrides())
    compiled = posed.compiled()
    given = compiled, posed.vector(experiment.shape)
    rest = posed.rest(compiled)
    return lambda: Initial(*given, rest.copy(), experiment, method, rtol).run().require()


def timed(
    cases: dict[Any, Callable[[], Any]], repeats: int, often: Mapping[Any, int]
) -> dict[Any, list[float]]:
    """Milliseconds of each case, all in turn, `often` times (else once) in each of the repeats.

    Each repeat has another order: the first run of other machine code than before takes longer, and
    is not to be the same one.
    """
    seconds: dict[Any, list[float]] = {case: [] for case in cases}
    order, random = [case for case in cases for _ in range(often.get(case, 1))], Random(0)
    for _ in tqdm(range(repeats), "timing", leave=False):
        random.shuffle(order)
        for case in order:
            clock = time.process_time()
            cases[case]()
            seconds[case].append(1e3 * (time.process_time() - clock))
    return seconds


def worst(row: Row) -> float:
    """Worst error of all traces [%]."""
    return max(float(row[f"{name}_worst_%"]) for name in TRACES)


def at_error(rows: list[Row], error: float) -> float:
    """Milliseconds for a worst error [%], log-log between cases; the quickest if all are better."""
    points: list[tuple[float, float]] = []
    for row in sorted(rows, key=lambda row: float(row["ms"])):
        if not points or worst(row) < points[-1][0]:
            points.append((worst(row), float(row["ms"])))
    if error < points[-1][0]:
        return float("nan")
    offs, times = np.log(np.array(points[::-1])).T
    return float(np.exp(np.interp(np.log(error), offs, times)))


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Time every case; milliseconds are medians, spread is between the quartiles."""
    hand, experiment = Hand(), load_experiment("dynamometer")[0].experiment
    exact = simulate(hand, experiment, method="Radau", rtol=1e-9).require()
    repeats = 3 if quick else 15
    fast = {("alone", rtol): alone(hand, experiment, rtol) for _, rtol in FAST}
    fast |= {case: by_scipy(hand, experiment, *case) for case in FAST}
    stock = {case: by_scipy(hand, experiment, *case) for case in STOCK}
    slow = {case: by_scipy(hand, experiment, *case) for case in EXPLICIT}
    spent = timed({**fast, **stock, **slow}, 1, {})  # compiled now
    spent |= timed({**fast, **stock}, repeats, dict.fromkeys(fast, 10))
    rows = []
    for method, rtol in (*FAST, *STOCK, *EXPLICIT):
        run = simulate(hand, experiment, method=method, rtol=rtol).require()
        low, middle, high = np.quantile(spent[method, rtol], (0.25, 0.5, 0.75))
        rows.append(
            {
                "method": method,
                "rtol": f"{rtol:g}",
                "ms": float(middle),
                "spread_ms": float(high - low),
                "alone_ms": statistics.median(spent.get(("alone", rtol), [np.nan]))
                if method == "Rodas"
                else float("nan"),
                "evaluations": run.cost.evaluations,
                "jacobians": run.cost.jacobians,
                **errors(run, exact),
            }
        )
    return rows, [*_bounds(rows), *_ratios(rows, spent)]


def _ratios(rows: list[Row], spent: Mapping[Any, list[float]]) -> list[Row]:
    """Time of the best stock method over ours at equal error; 95 % interval over repeats."""
    draw, known = np.random.default_rng(0), {case: np.array(ms) for case, ms in spent.items()}
    again = [
        {case: float(np.median(draw.choice(ms, ms.size))) for case, ms in known.items()}
        for _ in range(RESAMPLES)
    ]
    shown = []
    for error in (1.0, 0.1):
        gain, best = _gain(rows, error)
        drawn = [
            _gain([{**row, "ms": each[row["method"], float(row["rtol"])]} for row in rows], error)
            for each in again
        ]
        low, high = np.percentile([value for value, _ in drawn], (2.5, 97.5))
        name = f"best stock method ({best}) over Rodas at {error:g} %"
        row = must_show(name, gain, 10.0, gain >= 10.0)
        shown.append({**row, "low": float(low), "high": float(high)})
    return shown


def _gain(rows: list[Row], error: float) -> tuple[float, str]:
    """The ratio, and which method is the best of scipy's."""
    methods: dict[str, list[Row]] = {}
    for row in rows:
        methods.setdefault(str(row["method"]), []).append(row)
    mine = at_error(methods.pop("Rodas"), error)
    times = {name: at_error(some, error) for name, some in methods.items()}
    best = min(times, key=lambda name: np.nan_to_num(times[name], nan=np.inf))
    return times[best] / mine, best


def _bounds(rows: list[Row]) -> list[Row]:
    fast = [row for row in rows if row["method"] == "Rodas"]
    grasp = next(float(row["ms"]) for row in fast if row["rtol"] == "0.0001")
    dearer = max(float(row["ms"]) / float(row["alone_ms"]) for row in fast)
    return [
        must_show("dynamometer grasp at rtol 1e-4 [ms]", grasp, 30.0, grasp <= 30.0),
        must_show("solve_ivp over the compiled steps alone", dearer, 1.5, dearer <= 1.5),
    ]


if __name__ == "__main__":
    main(__doc__, "accuracy_work", measure)
