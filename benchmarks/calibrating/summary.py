"""From cases to figures: recovery, coverage, labels, wrong models; each with a 95 % interval."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.calibrating.cases import NINE
from benchmarks.harness import Row, interval, must_show

Cases = Sequence[dict[str, Any]]
# What a rich campaign can identify; the rest is hardly visible beside friction.
IDENTIFIABLE = tuple(name for name in NINE if not name.endswith("coulomb_friction"))
HIDDEN_ON_PURPOSE = "object.damping"
ERROR, NOMINAL = 0.02, (0.92, 0.98)


def share(hits: Sequence[bool]) -> dict[str, float]:
    """Share of hits with its 95 % interval (Wilson)."""
    from scipy.stats import binomtest

    found = binomtest(int(np.sum(hits)), len(hits)).proportion_ci(method="wilson")
    return {"value": float(np.mean(hits)), "low": float(found.low), "high": float(found.high)}


def _held(name: str, found: dict[str, float], low: float, high: float = 1.0) -> Row:
    """A share that must lie between two bounds, its 95 % interval beside it."""
    bound = low if high == 1.0 or found["value"] < low else high
    row = must_show(name, found["value"], bound, low <= found["value"] <= high)
    return {**row, "low": found["low"], "high": found["high"]}


def _of(cases: Cases, name: str) -> list[dict[str, Any]]:
    return [case["parameters"][name] for case in cases]


def recovery(cases: Cases, kind: str) -> tuple[list[Row], list[Row]]:
    """Rows and figures of cases with the nine parameters 20 % off."""
    rows = [_recovered(name, _of(cases, name), kind) for name in NINE]
    found = [row for row in rows if "median_error" in row]
    good = [row for row in found if row["labelled"] <= 0.5 and row["median_error"] <= ERROR]
    worst = max((row["median_error"] for row in found), default=0.0)
    agree = share([all(case["starts"]) for case in cases])
    return rows, [
        must_show(f"{kind}: parameters recovered to 2 %, of nine", len(good), 6, len(good) >= 6),
        must_show(f"{kind}: worst median error where not labelled", worst, ERROR, worst <= ERROR),
        _held(f"{kind}: campaigns in which all starts agree", agree, 1.0),
    ]


def _recovered(name: str, found: Sequence[dict[str, Any]], kind: str) -> Row:
    errors = np.abs([each["error"] for each in found if each["label"] == "identified"])
    spread = interval(errors.tolist()) if errors.size else {}
    median = {"median_error": float(np.median(errors))} if errors.size else {}
    return {
        "study": kind,
        "parameter": name,
        "cases": len(found),
        "labelled": float(np.mean([each["label"] != "identified" for each in found])),
        **median,
        **{f"error_{key}": value for key, value in spread.items()},
        "covered": share([each["covers"] for each in found])["value"],
    }


def coverage(cases: Cases) -> tuple[list[Row], list[Row]]:
    """Rows and figures of how often intervals hold the truth, and of labels."""
    rows, figures = [], []
    for name in (*NINE, HIDDEN_ON_PURPOSE):
        found = _of(cases, name)
        ours = share([each["covers"] for each in found])
        usual = share([each["textbook_covers"] for each in found])
        label = share([each["label"] != "identified" for each in found])
        rows.append(
            {
                "study": "coverage",
                "parameter": name,
                "cases": len(found),
                "covered": ours["value"],
                "covered_low": ours["low"],
                "covered_high": ours["high"],
                "textbook": usual["value"],
                "labelled": label["value"],
                "median_error": float(np.median(np.abs([each["error"] for each in found]))),
                "median_reach": float(np.median([each["reach"] for each in found])),
            }
        )
        if name == HIDDEN_ON_PURPOSE:
            figures.append(_held("contact damping labelled", label, 0.95))
            continue
        figures.append(_held(f"coverage of {name}", ours, *NOMINAL))
        if name in IDENTIFIABLE:
            figures.append(_held(f"{name} wrongly labelled", label, 0.0, 0.05))
    wrong = share([bool(case["repeats"]) for case in cases])
    figures.append(_held("right models said to leave what repeats", wrong, 0.0, 0.05))
    return rows, figures


def one_run(cases: Cases) -> tuple[list[Row], list[Row]]:
    """Wire elasticity beside object stiffness in a single run: both must be labelled."""
    names = list(cases[0]["parameters"])
    both = [all(case["parameters"][n]["label"] != "identified" for n in names) for case in cases]
    found = share(both)
    row = {"study": "one run", "parameter": " and ".join(names), "cases": len(cases),
           "labelled": found["value"], "labelled_low": found["low"]}  # fmt: skip
    name = "wire elasticity and object stiffness labelled in one run"
    return [row], [_held(name, found, 0.95)]


def wrong_model(cases: Cases) -> tuple[list[Row], list[Row]]:
    """Models that lack an effect: the cost falls, parameters are biased, and that is reported."""
    rows = []
    for case in cases:
        falls = [after / given for given, after, _ in case["gap"].values()]
        wrong = [not each["covers"] for each in case["parameters"].values()]
        rows.append(
            {
                "study": "wrong model",
                "hidden": case["hidden"],
                "seed": case["seed"],
                "misfit_left": float(np.median(falls)),
                "parameters_wrong": int(np.sum(wrong)),
                "reported": bool(case["repeats"]),
                "repeats": case["share"],
            }
        )
    reported = share([row["reported"] for row in rows])
    fell = share([row["misfit_left"] < 1.0 for row in rows])
    off = share([row["parameters_wrong"] > 0 for row in rows])
    return rows, [
        _held("wrong model: misfit falls", fell, 1.0),
        _held("wrong model: intervals that miss", off, 1.0),
        _held("wrong model: reported that the residual repeats", reported, 0.95),
    ]
