"""The command that prints the paper's Table II for recordings of a hand."""

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from hannes.commands.cli_output import add_force, add_json, print_json
from hannes.commands.cli_trust import add_trust

if TYPE_CHECKING:
    from hannes.identification.comparison.comparison import Compared, Condition, Row

LABEL = 26  # characters of the first column
EXAMPLES = {
    "compare": """\
hannes compare campaign.toml
hannes compare campaign.toml --out results/table-2 --json

It simulates each recording under its own command by the campaign's hand, prints
Table II and equation 4 of the paper, and draws Figs. 6, 7 and 8 with both.

campaign.toml:
  base = "results/closure/hand.toml"      # the hand; left out: the shipped one
  [[recording]]
  file = "left_*.csv"                     # repeats: their spread stands beside the error
  experiment = "void-closure"
  condition = "void"
  unit = "left"                           # one of several hands, as in Fig. 7
  [[recording]]
  file = "right_*.csv"
  experiment = "void-closure"
  condition = "void"
  unit = "right\"""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the command; `command(name, call, description)` makes its parser."""
    compare = command("compare", _compare, "the paper's Table II for your recordings")
    compare.add_argument("campaign", help="a campaign's .toml file")
    compare.add_argument(
        "--out",
        metavar="FOLDER",
        help="folder of the results (as the campaign says, with -compare at its end)",
    )
    add_force(compare)
    add_json(compare)
    add_trust(compare)


def _compare(chosen: argparse.Namespace) -> None:
    from hannes.campaigns.campaign_file import read_campaign
    from hannes.commands.compare import compare

    campaign = read_campaign(chosen.campaign)
    out = chosen.out or campaign.out.with_name(f"{campaign.out.name}-compare")
    result = compare(campaign, out=out, force=chosen.force)
    if chosen.json:
        print_json(result.plain())
    else:
        print("\n".join([*table_2(result), f"open {out}/index.html"]))


def table_2(result: "Compared") -> list[str]:
    """The comparison as lines for a terminal."""
    from hannes.report.comparison import sentence
    from hannes.simulation.grasp_metrics import DEFINITIONS

    lines = [sentence(result), *(f"caution: {each}" for each in result.cautions)]
    lines.append(f"{result.campaign.title}: error [%] = 100 (measured - simulated) / measured")
    for condition in result.conditions:
        lines += _condition_lines(condition)
    lines += [f"  {name}: {DEFINITIONS[name]}" for name in result.metrics]
    return [*lines, *(f"{each}." for each in result.notes)]


def _condition_lines(condition: "Condition") -> list[str]:
    units = [unit for unit in condition.units if unit]
    of = f" of {', '.join(units)}" if units else ""
    count = len(condition.runs)
    lines = [f"{condition.name} ({count} recording{'' if count == 1 else 's'}{of})"]
    if condition.rows:
        heads = ("measured", "± repeats", "± units", "simulated", "error [%]")
        lines.append("  " + " " * LABEL + "".join(f"{each:>11}" for each in heads))
    lines += [_row_line(row, row.metric) for row in condition.rows]
    if len(units) > 1:
        lines += [
            _row_line(row, f"{row.metric}, {unit}")
            for unit, rows in condition.by_unit.items()
            for row in rows
        ]
    return lines + [f"  without {name}: {why}" for name, why, _ in condition.left_out]


def _row_line(row: "Row", label: str) -> str:
    cells = (row.measured.mean, row.measured.repeats, row.measured.units, row.simulated.mean)
    texts = ["-" if each is None else f"{each:.4g}" for each in cells]
    return f"  {f'{label} [{row.unit}]':<{LABEL}}" + "".join(
        f"{each:>11}" for each in (*texts, f"{row.error:+.1f}")
    )
