"""What `hannes evaluate` writes: evaluation.json and the page of it."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hannes.core.io.atomic_files import atomic_folder
from hannes.recognition.evaluate import Subject
from hannes.recognition.model import Model


def write(out: str | Path, evaluation: Mapping[str, Any], force: bool = False) -> None:
    """Write evaluation.json and report.html to a folder, whole or not at all.

    `force`: results of another command there are replaced, too.
    """
    from hannes.report.evaluation import page

    with atomic_folder(out, "evaluate", force) as folder:
        text = json.dumps(evaluation, indent=1, ensure_ascii=False, allow_nan=False)
        (folder / "evaluation.json").write_text(text + "\n", encoding="utf-8")
        (folder / "report.html").write_text(page(evaluation), encoding="utf-8")


def simpler_ways(
    dataset: str | Path, model: Model, subjects: Sequence[Subject]
) -> dict[str, dict[str, Any]]:
    """Scores of the look-up of current, by a data set's grasps, and of the analytic estimate.

    Raises BadInput where the file is no data set.
    """
    from hannes.dataset.read import read
    from hannes.recognition.baselines import Estimate, analytic, baseline_scores, look_up
    from hannes.recognition.training_set import grasps
    from hannes.simulation.hand.hand import Hand

    data = read(dataset)
    ways: dict[str, Estimate] = {
        "look_up": look_up(grasps(data, data.role("train"), model.windowing), data.path),
        "analytic": analytic(Hand().parameters),
    }
    return {
        name: baseline_scores(way, model.windowing, model.border, subjects)
        for name, way in ways.items()
    }
