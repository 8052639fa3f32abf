"""The tables of the page, as plain rows of text."""

from collections.abc import Mapping

from hannes.report.formats import decimals, number, power, signed
from hannes.report.paper import published
from hannes.report.table import Table
from hannes.simulation.grasp_metrics import DEFINITIONS, GraspMetrics, relative_error, void_current
from hannes.simulation.hand.hand import Hand
from hannes.simulation.trajectory import Trajectory


def table_1(hand: Hand) -> Table:
    """Orders of magnitude of friction: published beside ours."""
    rows = []
    for each in published.TABLE_1:
        ours = hand.parameters[f"{each.part}.{each.parameter}"] * each.scale
        cells = (power(each.magnitude), number(ours), f"{number(ours / each.magnitude, 2)} ×")
        rows.append((f"{each.place} {each.symbol}", each.unit, *cells))
    return Table(
        "table1",
        "Table I: friction at joints and guides",
        ("Parameter", "Unit", "Published magnitude", "Ours", "Ours / published"),
        tuple(rows),
        "The paper publishes orders of magnitude only; the values within them are choices.",
    )


def table_2(ours: GraspMetrics) -> Table:
    """The dynamometer grasp: the paper's hand, its model, ours, and equation 4 for both models."""
    rows = []
    for each in published.TABLE_2:
        value, places = getattr(ours, each.name), 1 if each.unit == "N" else 3
        row = [f"{each.symbol} [{each.unit}]"]
        row += [decimals(v, places) for v in (each.hand, each.model, value)]
        row += [signed(relative_error(each.hand, v)) for v in (each.model, value)]
        rows.append(tuple(row))
    rows.append(_contact_row(ours))
    return Table(
        "table2",
        "Table II: the dynamometer grasp",
        (
            "Figure",
            "Hannes (paper)",
            "Model (paper)",
            "Ours",
            "Error of paper's model [%]",
            "Error of ours [%]",
        ),
        tuple(rows),
        "Errors are equation 4 of the paper with its sign, 100 (Hannes − model) / Hannes: positive "
        "where the model is the smaller. Contact is read from the paper's text (0.3 s).",
    )


def _contact_row(ours: GraspMetrics) -> tuple[str, ...]:
    errors = (signed(0.0), signed(relative_error(published.CONTACT, ours.contact)))
    return ("first contact [s]", "0.3", "0.3", decimals(ours.contact, 3), *errors)


def void_table(hand: Hand, unit_hand: Hand, unit: Trajectory) -> Table:
    """Void current of the hand unit in which only motor and gear dry friction differ."""
    ours = void_current(unit.time, unit["current"])
    rows = []
    for name, value in hand.parameters.items():
        if (other := unit_hand.parameters[name]) != value:
            measure = hand.parameters.declared[name].unit
            rows.append((f"{name} of the unit", f"{power(other, 3)} {measure}"))
            rows.append((f"{name} of the shipped hand", f"{power(value, 3)} {measure}"))
    rows += [
        (
            "void current, four hands (paper)",
            f"{published.VOID_CURRENT} ± {published.VOID_SPREAD} A",
        ),
        ("void current, model (paper)", f"{published.VOID_MODEL} A"),
        ("void current of the unit", f"{decimals(ours, 3)} A"),
    ]
    return Table(
        "void",
        "Void current",
        ("Quantity", "Value"),
        tuple(rows),
        "The paper's void current comes from other hands than its dynamometer grasp, so it is "
        "compared with a hand unit in which nothing but motor and gear dry friction differs.",
    )


def definitions() -> Table:
    """How each figure is measured; the paper leaves this open."""
    return Table(
        "definitions",
        "How the figures are measured",
        ("Figure", "Definition"),
        tuple((name, text) for name, text in DEFINITIONS.items()),
        "On the magnitude of the current, sampled at 1 kHz and smoothed by an 11 ms centred mean. "
        "The paper states no windows; another choice moves the slopes by some ten percent.",
    )


def parameters(hand: Hand) -> Table:
    """Every parameter of the hand with where its value comes from."""
    rows = tuple(
        (name, number(each.value, 4), each.unit, each.doc, each.source)
        for name, each in hand.parameters.declared.items()
        if not each.shared  # they are all 1
    )
    columns = ("Parameter", "Value", "Unit", "Meaning", "Source")
    return Table("parameters", "Every value of the shipped hand", columns, rows)


def must_show_table(rows: list[dict]) -> Table:
    """What must hold, what came out, and whether it does."""
    return Table(
        "mustshow",
        "What must hold",
        ("Figure", "Value", "At most", "Verdict"),
        tuple(
            (
                row["name"],
                f"{number(row['value'])} {row['unit']}".strip(),
                f"{number(row['bound'])} {row['unit']}".strip(),
                "holds" if row["holds"] else "does not hold",
            )
            for row in rows
        ),
    )


def gap_table(name: str, verdict: Mapping) -> Table:
    """RMS gaps of a diagnosis, by channel."""
    rows = tuple(
        (f"{channel} [{gap['unit']}]", *(_gap(gap, k) for k in GAPS))
        for channel, gap in verdict.get("gap", {}).items()
    )
    columns = ("Channel", "As given", "Baseline refitted", "With the effect", "Noise floor")
    return Table(
        name,
        "Gap between simulation and recordings (RMS)",
        columns,
        rows,
        f"On {verdict.get('gap_on') or 'the recordings in role show'}. Credit to an effect is only "
        "the step from the baseline to the effect.",
    )


GAPS = ("as_given", "before", "after", "floor")


def _gap(gap: Mapping, key: str) -> str:
    value = gap.get(key)
    return "\N{EN DASH}" if value is None else number(float(value))
