"""`hannes run`: simulate an experiment's variants; write recordings, summary.json, figure.svg."""

import json
import warnings
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io.atomic_files import atomic_folder
from hannes.core.io.inputs import noted
from hannes.core.io.outputs import reserved
from hannes.core.io.provenance import provenance
from hannes.core.model import differences
from hannes.core.recording.recording import Recording
from hannes.report import figure_runs
from hannes.simulation import grasp_metrics
from hannes.simulation.energy_balance import account
from hannes.simulation.experiment.friction_curve import FrictionCurve
from hannes.simulation.experiment.load import load
from hannes.simulation.experiment.variants import Variant
from hannes.simulation.hand.hand_file import effect_names, texts
from hannes.simulation.sensors import observe
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Cost, Trajectory

UNITS = {
    "contact": "s", "release": "s", "I_avgc": "A", "I_avgo": "A", "I_max": "A", "I_sc": "A/s",
    "I_so": "A/s", "F_max": "N", "void current": "A", "closing time": "s",
}  # fmt: skip
VOID_END = 0.3  # s, of the window of the void current


def run(
    name: str | Path,
    out: str | Path | None = None,
    *,
    method: str = "Rodas",
    rtol: float = 1e-4,
    force: bool = False,
    trust: bool = False,
) -> dict[str, Any]:
    """Simulate an experiment and write its results to `out` (default: results/<experiment>).

    `force`: results of another command there are replaced, too; `trust`: Python that the experiment
    names may run. Returns the content of summary.json. Raises BadInput for an experiment or folder
    that cannot be used, ComputationFailed where a simulation does not end; then nothing is written.
    """
    with noted() as inputs:
        asked, stem = load(name, trust=trust), Path(name).stem
    target = Path(out) if out is not None else Path("results") / stem
    with reserved("run", [target], inputs, folder=True, force=force):
        if isinstance(asked, FrictionCurve):
            return _curve(asked, stem, target)
        return _variants(asked, stem, target, method, rtol)


def _variants(
    asked: list[Variant], stem: str, target: Path, method: str, rtol: float
) -> dict[str, Any]:
    done = [_simulated(each, method, rtol) for each in asked]
    recordings = {each.name: observe(each.hand, ran) for each, ran in zip(asked, done, strict=True)}
    summary = {
        "experiment": stem,
        "title": asked[0].experiment.title,
        "out": str(target),
        "method": method,
        "rtol": rtol,
        "runs": [
            {**_row(each, ran), "energy": _energy(each, method, rtol)}
            for each, ran in zip(asked, done, strict=True)
        ],
        **provenance(),
    }
    svg = figure_runs.runs_svg(asked[0].experiment.title, recordings)
    files = {each.file: recordings[each.name] for each in asked}
    return _written(target, files, summary, svg)


def _curve(curve: FrictionCurve, stem: str, target: Path) -> dict[str, Any]:
    recording = curve.recording()
    peaks = {
        name: {"value": float(recording[name].max()), "unit": recording.units[name]}
        for name in recording.names
        if name.endswith("_friction")
    }
    summary = {
        "experiment": stem,
        "title": curve.title,
        "out": str(target),
        "runs": [{"name": "", "recording": "recording.h5", "peaks": peaks}],
        **provenance(),
    }
    return _written(
        target,
        {"recording.h5": recording},
        summary,
        figure_runs.friction_svg(curve.title, recording),
    )


def _simulated(variant: Variant, method: str, rtol: float) -> Trajectory:
    """Simulate one variant; the solver's own words are kept in the outcome, not printed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return simulate(variant.hand, variant.experiment, method=method, rtol=rtol).require()


def _row(variant: Variant, ran: Trajectory) -> dict[str, Any]:
    """One simulation's line in the summary."""
    return {
        "name": variant.name,
        "recording": variant.file,
        "outcome": ran.outcome.value,
        "controller": variant.experiment.controller,
        "metrics": measured(ran),
        "cost": {**_cost(ran.cost), "jacobian": ran.compiled.jacobian_kind},
        "effects": effect_names(variant.hand),
        "parameters": texts(variant.hand, differences(variant.hand)),
    }


def _cost(cost: Cost) -> dict[str, Any]:
    """Work of the solver; smooth parts lie between kinks of the reference."""
    return {
        "evaluations": cost.evaluations,
        "jacobians": cost.jacobians,
        "smooth_parts": cost.steps,
        "seconds": float(cost.seconds),
    }


def _energy(variant: Variant, method: str, rtol: float) -> dict[str, Any]:
    """Where the electrical energy went [J], and the share unaccounted for; or why there is none."""
    try:
        found = account(variant.hand, variant.experiment, method=method, rtol=rtol)
    except BadInput as error:
        return {"reason": str(error)}
    unit = {"residual": "1"}
    return {name: {"value": x, "unit": unit.get(name, "J")} for name, x in found.items()}


def measured(ran: Trajectory) -> dict[str, dict[str, Any]]:
    """Figures of merit with unit and definition: of a grasp, or of a free closure."""
    time, position = ran.time, ran["position"]
    if ran.experiment.object is not None:
        found = asdict(grasp_metrics.grasp_metrics(time, ran["current"], ran["force"], position))
    else:
        found = _free(time, ran["current"], position)
    return {
        name: {
            "value": float(value) if np.isfinite(value) else None,
            "unit": UNITS[name],
            "definition": grasp_metrics.DEFINITIONS.get(name, "last total force above 1 N"),
        }
        for name, value in found.items()
    }


def _free(time: np.ndarray, current: np.ndarray, position: np.ndarray) -> dict[str, float]:
    found = {}
    if time[-1] >= VOID_END:
        found["void current"] = grasp_metrics.void_current(time, current)
    if position[-1] > 0.5 * position.max() > 0.0:  # it ends closed
        found["closing time"] = grasp_metrics.closing_time(time, position)
    return found


def _written(
    target: Path, recordings: Mapping[str, Recording], summary: dict[str, Any], svg: str
) -> dict[str, Any]:
    """Write the results folder, whole or not at all; return the summary."""
    with atomic_folder(target, "run", force=True) as folder:
        for file, recording in recordings.items():
            recording.to_hdf5(folder / file)
        text = json.dumps(summary, indent=1, ensure_ascii=False, allow_nan=False)
        (folder / "summary.json").write_text(text + "\n", encoding="utf-8")
        (folder / "figure.svg").write_text(svg, encoding="utf-8", newline="\n")
    return summary
