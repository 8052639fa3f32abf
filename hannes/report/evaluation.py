"""The page of `hannes evaluate`: rigid or soft by object, as Table III, then what supports it."""

from collections.abc import Mapping
from typing import Any

from hannes.core.io.provenance import versions
from hannes.report.evaluation_tables import (
    baselines,
    confusion,
    estimates,
    learning_curves,
    of_class,
)
from hannes.report.figure_evaluation import figures
from hannes.report.formats import decimals, number
from hannes.report.page import render
from hannes.report.table import Table

SCORES = ("f1_windows", "f1_grasps")
NOTE = (
    "F1 by the paper's formula: 2 R / (R + 1), R the share that is right. Windows between contact "
    "and release count, at 5 % of the peak force. “Don't know” counts as wrong."
)


def page(evaluation: Mapping[str, Any]) -> str:
    """Return report.html: self-contained, no script, no network."""
    found = dict(evaluation)
    return render(
        "evaluation.html.j2",
        {
            "title": found["title"],
            "trained": found["trained"],
            "sentence": sentence(found),
            "worst": worst(found),
            "objects": _objects(found),
            "figures": figures(found),
            "beside": baselines(found),
            "tables": [confusion(found), estimates(found), *learning_curves(found)],
            "versions": versions(),
        },
    )


def sentence(evaluation: Mapping[str, Any]) -> str:
    """The score of all, in words."""
    count = len(evaluation["objects"])
    return (
        f"Rigid or soft: F1 {decimals(100.0 * evaluation['f1_windows'], 1)} % of windows and "
        f"{decimals(100.0 * evaluation['f1_grasps'], 1)} % of grasps, over "
        f"{count} object{'s' if count != 1 else ''}."
    )


def worst(evaluation: Mapping[str, Any]) -> str:
    """The object that is recognised least."""
    least = min(evaluation["objects"], key=lambda each: each["f1_windows"])
    return (
        f"Least well recognised: {least['name']} ({least['class']}), "
        f"F1 {decimals(100.0 * least['f1_windows'], 1)} % of windows."
    )


def _objects(evaluation: Mapping[str, Any]) -> Table:
    rows: list[tuple[str, ...]] = [
        (
            each["name"],
            each["class"],
            str(each["grasps"]),
            *(decimals(100.0 * each[key], 1) for key in SCORES),
            number(each["stiffness_N_per_m"] or float("nan"), 2),
            decimals(100.0 * each["stable_in_time"], 0),
        )
        for each in evaluation["objects"]
    ]
    for label in dict.fromkeys(each["class"] for each in evaluation["objects"]):
        mean = (of_class(evaluation["objects"], label, key) for key in SCORES)
        rows.append((f"{label.capitalize()} objects, mean ± SD", label, "", *mean, "", ""))
    whole = (decimals(100.0 * evaluation[key], 1) for key in SCORES)
    time = decimals(100.0 * evaluation["stable_in_time"], 0)
    rows.append(("Average", "", "", *whole, "", time))
    columns = (
        "Object", "Class", "Grasps", "F1, windows [%]", "F1, grasps [%]",
        "Stiffness estimated [N/m]", "Final decision within 150 ms [%]",
    )  # fmt: skip
    return Table("objects", "Rigid or soft", columns, tuple(rows), NOTE)
