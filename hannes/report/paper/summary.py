"""What depends on the day and the machine, beside the figures: kept off the page."""

from dataclasses import asdict
from typing import Any

from hannes.core.io.provenance import provenance
from hannes.report.paper.checks import Row
from hannes.report.paper.runs import Runs, measured
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Trajectory


def summary(runs: Runs, must_show: list[Row]) -> dict[str, Any]:
    """Content of summary.json: figures of every grasp, solver time, versions, date."""
    return {
        "rows": [*_grasps(runs), _solver_time(runs)],
        "must_show": must_show,
        **provenance(),
    }


def _grasps(runs: Runs) -> list[Row]:
    grasps: dict[str, Trajectory] = {
        "dynamometer": runs.rigid,
        "soft ball": runs.soft,
        "dynamometer, sampled": runs.sampled,
        **{f"{k:g} N/m": run for k, run in runs.sweep.items()},
    }
    return [{"name": name, **_plain(asdict(measured(run)))} for name, run in grasps.items()]


def _plain(values: dict[str, float]) -> dict[str, float | None]:
    """NaN has no place in JSON."""
    return {name: value if value == value else None for name, value in values.items()}


def _solver_time(runs: Runs) -> Row:
    """Best of three, all compiled: solver time of the dynamometer grasp at rtol 1e-4 [ms]."""
    costs = [simulate(runs.hand, runs.rigid.experiment).cost for _ in range(3)]
    best = min(costs, key=lambda cost: cost.seconds)
    return {
        "name": "solver time of the dynamometer grasp",
        "value": best.seconds * 1e3,
        "unit": "ms",
        "evaluations": int(best.evaluations),
    }
