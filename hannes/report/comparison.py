"""The page of `hannes compare`: Table II, equation 4, and Figs. 6, 7 and 8 for recordings."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hannes.core.io.provenance import versions
from hannes.report.figure_comparison import figures
from hannes.report.formats import number, signed
from hannes.report.page import render
from hannes.report.table import Table
from hannes.simulation.grasp_metrics import DEFINITIONS

if TYPE_CHECKING:
    from hannes.identification.comparison.comparison import Compared, Condition, Row

NO_VALUE = "–"
GROSS = 2.0  # times, either way, by which no model of the right experiment is off


def page(result: "Compared") -> str:
    """Return index.html: self-contained, no script, no network."""
    return render(
        "comparison.html.j2",
        {
            "title": result.campaign.title,
            "sentence": sentence(result),
            "notes": result.notes,
            "cautions": result.cautions,
            "conditions": [
                {
                    "name": each.name,
                    "tables": _tables(each, place),
                    "figures": figures(each, place),
                }
                for place, each in enumerate(result.conditions, 1)
            ],
            "left_out": _left_out(result),
            "definitions": _definitions(result),
            "recordings": _recordings(result),
            "versions": versions(),
        },
    )


def sentence(result: "Compared") -> str:
    """The largest relative error, in words."""
    if result.largest is None:
        return "None of the paper's metrics has a value for these recordings."
    condition, row = result.largest
    doubt = (
        " That far off it may be no gap of the model: is this the experiment, and the hand, that "
        "was recorded?"
    )
    return (
        f"Largest relative error: {row.metric}, {signed(row.error)} % (measured "
        f"{number(row.measured.mean)}, simulated {number(row.simulated.mean)} {row.unit}; "
        f"{condition.name}).{doubt if _gross(row.measured.mean, row.simulated.mean) else ''}"
    )


def _gross(measured: float, simulated: float) -> bool:
    """Whether two values are of opposite sign, or one is some times the other."""
    small, large = sorted((abs(measured), abs(simulated)))
    return measured * simulated < 0.0 or large > GROSS * small


def _tables(condition: "Condition", place: int) -> list[Table]:
    """Table II of a condition, and by unit where there are several."""
    if not condition.rows:
        return []
    columns = (
        "Metric", "Measured", "± repeats", "± units", "Simulated", "Error [%]", "Recordings",
    )  # fmt: skip
    note = "Error: 100 (measured − simulated) / measured, equation 4 of the paper with its sign."
    if not condition.repeated:
        note += " No repeats: how far runs differ by themselves is unknown."
    rows = tuple(_cells(row, row.metric) for row in condition.rows)
    made = [Table(f"table2-{place}", f"Table II: {condition.name}", columns, rows, note)]
    if len(condition.units) > 1:
        apart = tuple(
            _cells(row, f"{row.metric}, {unit or 'unnamed'}")
            for unit, own in condition.by_unit.items()
            for row in own
        )
        made.append(Table(f"units-{place}", f"By unit: {condition.name}", columns, apart))
    return made


def _cells(row: "Row", label: str) -> tuple[str, ...]:
    measured, simulated = row.measured, row.simulated
    return (
        f"{label} [{row.unit}]",
        number(measured.mean, 4),
        NO_VALUE if measured.repeats is None else number(measured.repeats, 2),
        NO_VALUE if measured.units is None else number(measured.units, 2),
        number(simulated.mean, 4),
        signed(row.error),
        str(measured.runs),
    )


def _left_out(result: "Compared") -> Table:
    rows = tuple(
        (name, condition.name, why, _named(names))
        for condition in result.conditions
        for name, why, names in condition.left_out
    )
    columns = ("Metric", "Condition", "Why", "Recordings")
    return Table("left-out", "Metrics that are left out", columns, rows)


def _definitions(result: "Compared") -> Table:
    note = (
        "On the magnitude of the current, resampled at 1 kHz and smoothed by an 11 ms centred "
        "mean, of both alike. Time counts from the start of the command. Where only a dynamometer "
        "was recorded (sensor_N), it takes the place of the force, simulated as well. Spreads are "
        "sample standard deviations: of repeats about their unit's mean, and of the units' means. "
        "The paper states no windows; another choice moves the slopes by some ten percent."
    )
    rows = tuple((name, DEFINITIONS[name]) for name in result.metrics)
    return Table("definitions", "Definitions", ("Metric", "Definition"), rows, note)


def _recordings(result: "Compared") -> Table:
    rows = tuple(
        (
            each.run.entry.name,
            condition.name,
            each.run.unit or NO_VALUE,
            f"{1e3 * each.run.shift:.4g} ms",
            ", ".join(f"{name} {signed(p.error)}" for name, p in each.pairs.items()) or NO_VALUE,
        )
        for condition in result.conditions
        for each in condition.runs
    )
    columns = ("Recording", "Condition", "Unit", "Command starts at", "Errors [%]")
    return Table("recordings", "Recordings", columns, rows)


def _named(names: Sequence[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
