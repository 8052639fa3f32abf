"""The page of a calibration: the sentence, the values with their intervals, the residual."""

from typing import TYPE_CHECKING

import numpy as np

from hannes.core.io.provenance import versions
from hannes.report.figure_calibration import figures
from hannes.report.formats import number
from hannes.report.page import render
from hannes.report.table import Table

if TYPE_CHECKING:
    from hannes.identification.calibration.result import Fit


MOST_UNCERTAIN = 8


def page(result: "Fit") -> str:
    """Return report.html: self-contained, no script, no network."""
    return render(
        "calibration.html.j2",
        {
            "title": result.campaign.title,
            "sentence": result.sentence,
            "remaining": " ".join(result.remaining),
            "values": _values(result),
            "gaps": _gaps(result),
            "starts": _starts(result),
            "runs": _runs(result),
            "recordings": _recordings(result),
            "data_issues": _data_issues(result),
            "uncertain": _uncertain(result),
            "figures": figures(result),
            "seed": result.seed,
            "versions": versions(),
        },
    )


def _values(result: "Fit") -> Table:
    from hannes.identification.calibration.result import value_text

    rows = [
        (
            each.name,
            number(each.nominal, 4),
            value_text(each),
            each.label + (f" with {', '.join(each.partners)}" if each.partners else ""),
            each.reason or "–",
            f"{number(each.textbook[0], 4)} to {number(each.textbook[1], 4)}",
            number(each.freedom, 2),
        )
        for each in result.answers
    ]
    columns = (
        "Parameter", "Nominal", "Value and 95 % interval", "Label", "Why", "Textbook interval",
        "Degrees of freedom",
    )  # fmt: skip
    note = (
        f"Intervals come from the scatter of {len(result.spread.influences)} {result.spread.unit}, "
        "so what changes from run to run is in them. The textbook interval takes every sample as "
        "independent; it is printed for contrast."
        + (
            " With one recording, what changes from run to run is in no interval."
            if result.spread.unit != "runs"
            else ""
        )
    )
    return Table("values", "Calibrated parameters", columns, tuple(rows), note)


def _gaps(result: "Fit") -> Table:
    shown = [("never fitted", result.gap), ("fitted", result.fitted_gap)]
    rows = [
        _gap(result, name, role, gap[name])
        for name in result.fitted_gap
        for role, gap in shown
        if name in gap
    ]
    columns = (
        "RMS gap",
        "Recordings",
        "As given",
        "Calibrated",
        "Noise floor",
        "Same in every run",
    )
    note = (
        f"In brackets: relative to the recorded signal. The noise floor is {result.floor_from}. "
        "The last column is of the fitted recordings, in means over 10 ms."
    )
    if not rows and result.found.interrupted:
        note = "Interrupted before any recording was predicted."
    elif not result.gap:
        note += " No recording was held out, so nothing here is a prediction."
    return Table("gaps", "Prediction", columns, tuple(rows), note)


def _gap(result: "Fit", name: str, role: str, gap: dict[str, float]) -> tuple[str, ...]:
    unit, whole = result.plant.channels[name], max(gap["recorded"], 1e-300)
    sizes = [
        f"{number(gap[key])} ({number(100.0 * gap[key] / whole)} %)"
        for key in ("as_given", "after")
    ]
    common = result.repeatable_residual.common.get(name, np.nan) if role == "fitted" else np.nan
    return (f"{name} [{unit}]", role, *sizes, number(gap["floor"], 2), number(common, 2))


def _starts(result: "Fit") -> Table:
    rows = tuple(
        (str(place + 1), number(start.cost, 5), "yes" if agrees else "no")
        for place, (start, agrees) in enumerate(
            zip(result.found.starts, result.agreeing, strict=True)
        )
    )
    note = (
        "Each from another point about the nominal values. They agree where the cost is as small "
        "and every identified parameter ends within half an interval's half-width."
    )
    return Table("starts", "Starting points", ("Start", "Cost", "Agrees"), rows, note)


def _runs(result: "Fit") -> Table:
    plan, rows = result.found.plan, []
    for each in result.plain()["runs"]:
        sizes = each["differs"]
        most = sorted(sizes, key=lambda name: -abs(sizes[name] / plan.nuisance[name]))[:2]
        differences = [f"{name} {_off(result, name, sizes[name])}" for name in most]
        start = f"{1e3 * each['starts_late_s']:+.2f} ms"
        rows.append((each["file"], each["condition"], start, ", ".join(differences) or "–"))
    columns = ("Recording", "Condition", "Starts late by", "Differs most in")
    note = "What each run most likely did differently, under the assumed run-to-run variability."
    return Table("runs", "Run by run", columns, tuple(rows), note)


def _off(result: "Fit", name: str, size: float) -> str:
    """Deviation of a run in a parameter: a share of the nominal value, unless that is zero."""
    parameters = result.campaign.plant.parameters
    if parameters[name]:
        return f"{100.0 * size / abs(parameters[name]):+.2g} %"
    unit = parameters.declared[name].unit
    return f"{size:+.2g}" if unit == "1" else f"{size:+.2g} {unit}"


def _uncertain(result: "Fit") -> Table:
    """What was not asked for but held uncertain, as far as it moved."""
    found = result.plain()["doubted"]
    moved = sorted(found.items(), key=lambda item: -abs(item[1]["deviations"]))[:MOST_UNCERTAIN]
    rows = tuple(
        (name, number(each["given"], 4), number(each["value"], 4), each["unit"],
         number(each["deviations"], 2))
        for name, each in moved
    )  # fmt: skip
    note = (
        f"Of {len(found)} uncertain parameters, those that moved most; a deviation is "
        "its assumed standard deviation. They stand in hand.toml too."
    )
    columns = ("Uncertain parameter", "Nominal", "Value", "Unit", "Deviations")
    return Table("uncertain", "Uncertain parameters", columns, rows, note)


def _data_issues(result: "Fit") -> Table:
    rows = tuple((name, str(each)) for name, each in result.data_issues)
    note = "The campaign accepts these kinds: each misleads the fit as far as it goes."
    return Table("findings", "What the data check found", ("Recording", "Finding"), rows, note)


def _recordings(result: "Fit") -> Table:
    roles = result.plain()["recordings"]
    rows = tuple((role, ", ".join(names) or "none") for role, names in roles.items())
    return Table("recordings", "Recordings by role", ("Role", "Recordings"), rows)
