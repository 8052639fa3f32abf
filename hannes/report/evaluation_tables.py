"""Tables of an evaluation: classes, confusion, estimates, baselines, learning curve."""

from statistics import fmean, stdev
from typing import Any

from hannes.report.formats import decimals, number
from hannes.report.table import Table

NO_ESTIMATE = (
    "Grasps without an estimate, because the motor current showed no contact, count as further off "
    "than any other, and as outside their interval."
)
CURVE = (
    "Each row is a classifier of its own, trained on that many grasps; the objects are the same."
)
BASELINES = (
    "Both give a stiffness; an object is rigid where it is above the border. Look-up: the most "
    "current so far, by a table of the training grasps. Analytic: one joint, wires that stretch, "
    "no friction or inertia, and the shipped hand's nominal values."
)
WORDS = {"look_up": "Look-up of current", "analytic": "Analytic estimate"}


def mean(values: list[float]) -> str:
    """Mean with the sample standard deviation, as the paper's; without it of one value."""
    if len(values) < 2:
        return decimals(values[0] if values else float("nan"), 1)
    return f"{decimals(fmean(values), 1)} ± {decimals(stdev(values), 1)}"


def of_class(objects: list[dict[str, Any]], label: str, key: str) -> str:
    """Mean and standard deviation of a score [%] over the objects of a class."""
    return mean([100.0 * each[key] for each in objects if each["class"] == label])


def confusion(evaluation: dict[str, Any]) -> Table:
    """Windows by class and prediction, and the calibration error of the probabilities."""
    words, rows = list(next(iter(evaluation["confusion"].values()))), []
    for true, answers in evaluation["confusion"].items():
        whole = sum(answers.values())
        shares = [decimals(100.0 * answers[word] / max(1, whole), 1) for word in words]
        rows.append((true, str(whole), *shares))
    error = decimals(100.0 * evaluation["reliability"]["calibration_error"], 1)
    since = {
        word: "never" if time is None else f"{number(1e3 * time, 2)} ms after contact"
        for word, time in evaluation["stable_after_s"].items()
    }
    note = (
        f"Probabilities are {error} points off on average (expected calibration error over "
        f"tenths). Median time of the final decision: soft objects {since['soft']}, rigid ones "
        f"{since['rigid']}; an object without contact counts as soft."
    )
    columns = ("Object is", "Windows", *(f"Predicted {word} [%]" for word in words))
    return Table("confusion", "Predictions by window", columns, tuple(rows), note)


def estimates(evaluation: dict[str, Any]) -> Table:
    """Peak force and stiffness: their errors, and the coverage of their intervals."""
    named = (("force", "Peak grip force"), ("stiffness", "Stiffness"))
    rows = tuple(
        (
            words,
            f"{each['answered']} of {each['grasps']}",
            decimals(_known(each["median_error_percent"]), 1),
            decimals(100.0 * each["interval_holds"], 1),
            decimals(each["interval_width"], 1),
        )
        for key, words in named
        if (each := evaluation[key])["answered"]
    )
    columns = (
        "From current and position alone", "Estimated grasps", "Median error [%]",
        "Coverage of 95 % intervals [%]", "Upper end over lower, median",
    )  # fmt: skip
    return Table("estimates", "Peak force and stiffness", columns, rows, NO_ESTIMATE)


def _known(value: float | None) -> float:
    return float("nan") if value is None else value


def baselines(evaluation: dict[str, Any]) -> list[Table]:
    """The classifier beside two ways that need none; nothing where they were not asked for."""
    if "baselines" not in evaluation:
        return []
    found = {"Classifier": evaluation}
    found |= {WORDS[name]: each for name, each in evaluation["baselines"].items()}
    rows = tuple(
        (
            words,
            decimals(100.0 * each["f1_windows"], 1),
            decimals(100.0 * each["f1_grasps"], 1),
            *(of_class(each["objects"], label, "f1_windows") for label in ("soft", "rigid")),
        )
        for words, each in found.items()
    )
    columns = (
        "Way", "F1, windows [%]", "F1, grasps [%]", "Soft objects, windows [%]",
        "Rigid objects, windows [%]",
    )  # fmt: skip
    return [Table("baselines", "Beside two simpler ways", columns, rows, BASELINES)]


def learning_curves(evaluation: dict[str, Any]) -> list[Table]:
    """Scores by the number of training grasps; nothing where they were not asked for."""
    if "learning_curve" not in evaluation:
        return []
    keys = ("f1_windows", "f1_grasps", "f1_worst", "stable_in_time")
    rows = tuple(
        (str(each["grasps"]), *(decimals(100.0 * each[key], 1) for key in keys))
        for each in evaluation["learning_curve"]
    )
    columns = (
        "Training grasps", "F1, windows [%]", "F1, grasps [%]", "Worst object [%]",
        "Final decision within 150 ms [%]",
    )  # fmt: skip
    return [Table("learning", "Learning curve", columns, rows, CURVE)]
