"""Table III beside ours: a classifier trained on simulated grasps, on ten objects."""

import json
from pathlib import Path
from typing import Any

from hannes.core.errors import BadInput
from hannes.report.evaluation_tables import (
    baselines,
    confusion,
    estimates,
    learning_curves,
    of_class,
)
from hannes.report.formats import decimals, number
from hannes.report.paper.checks import Row, row
from hannes.report.paper.published import TABLE_3, TABLE_3_AVERAGE, TABLE_3_BY_CLASS
from hannes.report.table import Table
from hannes.report.verdict_summary import ABOUT, Finding

BOUNDS = (5.0, 2.0, 15.0)  # % that F1 may lack: of windows, of grasps, of the worst object
NOTE = (
    "F1 by the paper's formula, in which the names of precision and recall are swapped; for an "
    "object of one class it is 2 R / (R + 1), R the share that is correct. The paper does not "
    "state what it counts. Here it counts windows between contact and release, at 5 % of the peak "
    "force, and whole grasps. Features look back, so the first window ends 100 ms after contact. "
    "“Don't know” counts as wrong. The paper has real objects and a real hand. Ours are virtual, "
    "with stiffnesses chosen within published ranges: the tasks compare, the figures do not."
)


def read(folder: str | Path) -> dict[str, Any]:
    """Content of evaluation.json of a results folder; BadInput where it is none."""
    file = Path(folder) / "evaluation.json"
    try:
        evaluation: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        found(evaluation)
        checks(evaluation)
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise BadInput(
            f"{file} is not written by this version's `hannes evaluate`: {error}; evaluate again"
        ) from None
    return evaluation


def checks(evaluation: dict[str, Any]) -> list[Row]:
    """What F1 lacks to 100 %: of windows, of grasps, of the worst object."""
    keys = ("f1_windows", "f1_grasps", "f1_worst")
    names = ("average per window", "average per grasp", "worst object per window")
    return [
        row(
            f"F1 of ten virtual objects, {name}, lacks", 100.0 - 100.0 * evaluation[key], bound, "%"
        )
        for key, name, bound in zip(keys, names, BOUNDS, strict=True)
    ]


def found(evaluation: dict[str, Any]) -> Finding:
    """The section of the page."""
    title, about = ABOUT["recognition"]
    tables = (
        _table(evaluation),
        confusion(evaluation),
        estimates(evaluation),
        *baselines(evaluation),
        *learning_curves(evaluation),
    )
    return Finding("recognition", title, about, tables=tables)


def _table(evaluation: dict[str, Any]) -> Table:
    rows: list[tuple[str, ...]] = [
        (
            each["name"],
            each["class"],
            decimals(TABLE_3[each["name"]], 1) if each["name"] in TABLE_3 else "–",
            decimals(100.0 * each["f1_windows"], 1),
            decimals(100.0 * each["f1_grasps"], 1),
            number(each["stiffness_N_per_m"] or float("nan"), 2),
            decimals(100.0 * each["stable_in_time"], 0),
        )
        for each in evaluation["objects"]
    ]
    rows += [_class_row(evaluation, *each) for each in TABLE_3_BY_CLASS.items()]
    average = [decimals(100.0 * evaluation[key], 1) for key in ("f1_windows", "f1_grasps")]
    time = decimals(100.0 * evaluation["stable_in_time"], 0)
    rows.append(("Average", "", decimals(TABLE_3_AVERAGE, 1), *average, "", time))
    columns = (
        "Object", "Class", "Paper, F1 [%]", "Ours, windows [%]", "Ours, grasps [%]",
        "Stiffness estimated [N/m]", "Final decision within 150 ms [%]",
    )  # fmt: skip
    return Table("table3", "Table III: rigid or soft", columns, tuple(rows), NOTE)


def _class_row(
    evaluation: dict[str, Any], label: str, paper: tuple[float, float]
) -> tuple[str, ...]:
    """Mean and standard deviation of F1 over the objects of a class."""
    ours = (of_class(evaluation["objects"], label, key) for key in ("f1_windows", "f1_grasps"))
    published = f"{decimals(paper[0], 1)} ± {decimals(paper[1], 1)}"
    return (f"{label.capitalize()} objects, mean ± SD", label, published, *ours, "", "")
