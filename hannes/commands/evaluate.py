"""What `hannes evaluate` writes: evaluation.json and the page of it."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hannes.core.io.atomic_files import atomic_folder
from hannes.recognition.evaluate import Subject
from hannes.recognition.model import Model
from hannes.recognition.training_set import TrainingSet, training_set


def write(out: str | Path, evaluation: Mapping[str, Any], force: bool = False) -> None:
    """Write evaluation.json and report.html to a folder, whole or not at all.

    `force`: results of another command there are replaced, too.
    """
    from hannes.report.evaluation import page

    with atomic_folder(out, "evaluate", force) as folder:
        text = json.dumps(evaluation, indent=1, ensure_ascii=False, allow_nan=False)
        (folder / "evaluation.json").write_text(text + "\n", encoding="utf-8")
        (folder / "report.html").write_text(page(evaluation), encoding="utf-8")


def further(
    model: Model, subjects: Sequence[Subject], curve: str | None, baselines: str | None
) -> dict[str, Any]:
    """Learning curve and simpler ways by the training grasps of data sets, where they are named.

    Raises BadInput where a file is no data set.
    """
    from hannes.recognition.evaluate import learning_curve
    from hannes.recognition.train import curve_of

    sets = {path: training_set(path, model.windowing) for path in {curve, baselines} if path}
    found: dict[str, Any] = {}
    if curve:
        found["learning_curve"] = learning_curve(curve_of(sets[curve], whole=model), subjects)
    if baselines:
        found["baselines"] = simpler_ways(sets[baselines], model, subjects)
    return found


def simpler_ways(
    given: TrainingSet, model: Model, subjects: Sequence[Subject]
) -> dict[str, dict[str, Any]]:
    """Scores of the look-up of current, by a data set's grasps, and of the analytic estimate."""
    from hannes.recognition.baselines import Estimate, analytic, baseline_scores, look_up
    from hannes.simulation.hand.hand import Hand

    ways: dict[str, Estimate] = {
        "look_up": look_up(given.grasps, given.data.path),
        "analytic": analytic(Hand().parameters),
    }
    return {
        name: baseline_scores(way, model.windowing, model.border, subjects)
        for name, way in ways.items()
    }
