"""The race against MuJoCo: time of a dynamometer grasp at equal error over its whole trace.

Runners, in one process, on one thread (nothing timed calls BLAS), by processor time, in turn,
repeated:

- hannes: its compiled steps at several tolerances, as batches run them; and through scipy's
  solve_ivp, as `simulate` does, which the bounds do not ask for and other rows show
- our equations in MuJoCo: its bodies and integrators, our forces in a compiled callback, at
  several steps of every integrator it has
- the same, linearised: with an expert's help, see benchmarks/mujoco/same.py; it makes MuJoCo's
  semi-implicit Euler hold at far longer steps
- MuJoCo's own elements (benchmarks/mujoco/elements.py): every integrator, wires as springs or as
  limits; with the impedance of contacts that comes nearest to our traces, and with one near
  its default, a little further off and cheaper

All run the 1.15 s of one experiment and record its state at 1 kHz; compiled code steps MuJoCo.
Force and tension follow from the states, on all sides outside the clock (the row "force and
tension" shows what ours cost). Models are compiled before.

Errors are worst and RMS over the trace, relative to its peak. For hannes and for our equations
in MuJoCo the truth is Radau at rtol 1e-9. MuJoCo's own elements are another model, so its error
is against itself at 5 us; the rows "against hannes" show how far off that is. The time at an
error lies between cases, log-log, on the lower envelope of a runner's cases; a runner whose
quickest case is better than asked is taken at that case.
"""

import itertools
import statistics
import time
from collections.abc import Mapping, Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.accuracy_work import TRACES, errors
from benchmarks.harness import Row, main, must_show
from benchmarks.mujoco.cases import (
    CALLED,
    IDIOMS,
    LINEARISED,
    LOOP,
    OURS,
    OWN,
    Case,
    Traces,
    called,
    ours,
    own,
    own_limit,
)
from benchmarks.mujoco.elements import Idiom
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Trajectory

# What is asked: runner, which error [%] and how small, least ratio of its time to ours.
CONTESTS = (
    *((who, "worst_%", 1.0, 60.0) for who in (CALLED, LINEARISED)),
    *((who, "worst_%", 0.1, 50.0) for who in (CALLED, LINEARISED)),
    *((who, "current_worst_%", 1.0, 60.0) for who in OWN.values()),
    *((who, "current_rms_%", 0.1, 150.0) for who in OWN.values()),
)
NOT_RACED = {
    "Exudyn": "ropes over sheaves, but contact of spheres, triangles and cables only, not of a "
    "rod with a cylinder; forces of one's own are Python functions, which would be what is timed",
    "Drake": "its Python interface has no tendons, nor dry friction in joints, which is most of "
    "the current of a free closure",
    "PyBullet": "no tendons or cables",
    "OpenSim (Simbody)": "springs along paths, but contact of spheres, half-spaces and meshes "
    "only, and controllers of one's own in C++ only",
    "Chrono": "cables as finite elements; not on PyPI (its name there is another package)",
}
RESAMPLES = 400
Times = dict[Case, list[float]]


def cost(points: Sequence[tuple[float, float]], error: float) -> float:
    """Time for an error on the lower envelope of (time, error), log-log; NaN out of reach."""
    times: list[float] = []
    offs: list[float] = []
    for spent, off in sorted(points):
        if np.isfinite(off) and (not offs or off < offs[-1]):
            times.append(spent)
            offs.append(off)
    if not offs or offs[-1] > error:
        return float("nan")
    return float(np.exp(np.interp(np.log(error), np.log(offs[::-1]), np.log(times[::-1]))))


def judged(case: Case) -> Row:
    """Errors [%] of a case, infinite where it diverged; `worst_%` is that of the worst trace."""
    found = errors(case.traces(), case.exact)
    found = {name: off if np.isfinite(off) else float("inf") for name, off in found.items()}
    return {"worst_%": max(found[f"{name}_worst_%"] for name in TRACES), **found}


def timed(cases: Sequence[Case], rounds: int) -> Times:
    """Milliseconds of processor time; hannes runs again before each way of every other runner."""
    mine = [case for case in cases if case.runner in (LOOP, OURS)]
    others = [case for case in cases if case.runner not in (LOOP, OURS)]
    ways = itertools.groupby(others, lambda case: (case.runner, case.way))
    order = [case for _, way in ways for case in (*mine, *way)]
    spent: Times = {case: [] for case in cases}
    for case in tqdm(order * rounds, "timing", leave=False):
        clock = time.process_time()
        case.run()
        spent[case].append(1e3 * (time.process_time() - clock))
    return spent


class Race:
    """What was timed and judged."""

    def __init__(self, spent: Times, found: dict[Case, Row]) -> None:
        self.spent, self.found = spent, found
        self.medians = {case: statistics.median(times) for case, times in spent.items()}
        random = np.random.default_rng(0)
        drawn = {
            case: np.median(random.choice(times, (RESAMPLES, len(times))), axis=1)
            for case, times in spent.items()
        }
        self.resampled = [{case: drawn[case][k] for case in drawn} for k in range(RESAMPLES)]

    def time(
        self, medians: dict[Case, float], runner: str, key: str, error: float
    ) -> tuple[float, str]:
        """Milliseconds that a runner's quickest way takes to an error; and that way."""
        ways: dict[str, list[tuple[float, float]]] = {}
        for case, spent in medians.items():
            if case.runner == runner:
                ways.setdefault(case.way, []).append((spent, self.found[case][key]))
        costs = [(cost(points, error), way) for way, points in ways.items()]
        return min(costs, key=lambda each: each[0] if np.isfinite(each[0]) else np.inf)

    def contest(self, runner: str, key: str, error: float, bound: float, mine: str = LOOP) -> Row:
        """A runner's time to an error over ours; 95 % interval over repeats (bootstrap)."""
        ratios = [
            self.time(medians, runner, key, error)[0] / self.time(medians, mine, key, error)[0]
            for medians in (self.medians, *self.resampled)
        ]
        low, high = np.percentile(ratios[1:], (2.5, 97.5))
        name = f"time over that of {mine} at {error:g} {key.replace('_', ' ')}: {runner}"
        theirs, way = self.time(self.medians, runner, key, error)
        ms = {"ms": theirs, "hannes_ms": self.time(self.medians, mine, key, error)[0]}
        row = must_show(name, ratios[0], bound, ratios[0] >= bound)
        return {**row, "low": float(low), "high": float(high), **ms, "way": way}

    def through_scipy(self, runner: str, key: str, error: float, bound: float) -> Row:
        """The same over `simulate`, as a row beside the others."""
        row = self.contest(runner, key, error, bound, OURS)
        runner_row = {"runner": row["name"], "way": row["way"], "ms": row["ms"]}
        return {**runner_row, "ratio": row["value"], "low": row["low"], "high": row["high"]}

    def rows(self) -> list[Row]:
        """One row for each case."""
        return [
            {
                **{"runner": case.runner, "way": case.way, "step": case.step},
                **{"ms": self.medians[case], "spread_ms": max(times) - min(times)},
                **self.found[case],
            }
            for case, times in self.spent.items()
        ]


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Judge every case once, then time all in turn; milliseconds are medians over repeats."""
    hand, experiment = Hand(), load_experiment("dynamometer")[0].experiment
    exact = simulate(hand, experiment, method="Radau", rtol=1e-9).require()
    idioms = tqdm(IDIOMS, "limits", leave=False)
    limits = {idiom: own_limit(hand, experiment, idiom) for idiom in idioms}
    given = (hand, experiment, exact)
    cases = [*ours(*given), *called(*given, helped=False), *called(*given, helped=True)]
    cases += [c for idiom in IDIOMS for c in own(hand, experiment, idiom, limits[idiom])]
    found = {case: judged(case) for case in tqdm(cases, "errors", leave=False)}
    race = Race(timed(cases, 2 if quick else 5), found)
    unraced = [{"runner": name, "note": why} for name, why in NOT_RACED.items()]
    rows = [*race.rows(), *apart(exact, limits), outputs(exact)]
    rows += [*(race.through_scipy(*asked) for asked in CONTESTS), *unraced]
    return aligned(rows), [race.contest(*asked) for asked in CONTESTS]


def aligned(rows: Sequence[Row]) -> list[Row]:
    """The same rows, each with all keys."""
    keys = {key: "" for row in rows for key in row}
    return [keys | row for row in rows]


def apart(exact: Trajectory, limits: Mapping[Idiom, Traces]) -> list[Row]:
    """How far the limits of MuJoCo's own elements lie from the hand's own equations."""
    truth = {name: exact[name] for name in TRACES}
    return [
        {
            **{"runner": OWN[idiom.impedance], "way": str(idiom), "step": "against hannes"},
            **errors(limit, truth),
        }
        for idiom, limit in limits.items()
    ]


def outputs(exact: Trajectory) -> Row:
    """What force and tension at all samples cost hannes and our equations in MuJoCo alike."""
    clock = time.perf_counter()
    exact.compiled.observed.observe(
        exact.time, exact.states, exact.parameters, exact.knots, exact.memories
    )
    ms = 1e3 * (time.perf_counter() - clock)
    return {"runner": LOOP, "way": "force and tension", "step": "all samples", "ms": ms}


if __name__ == "__main__":
    main(__doc__, "peers", measure)
