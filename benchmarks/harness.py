"""What every benchmark shares: its arguments, its table, its JSON, its verdict on bounds."""

import argparse
import json
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

Row = dict[str, Any]


def must_show(name: str, value: float, bound: float, holds: bool) -> Row:
    """One figure that an issue asks for, with its bound and whether it holds."""
    return {"name": name, "value": value, "bound": bound, "holds": bool(holds)}


def arguments(doc: str, module: str) -> argparse.Namespace:
    """Parse `--quick` and `--json FILE|-`."""
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks.{module}",
        description=doc,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="fewer repeats, for a first look")
    parser.add_argument("--json", metavar="FILE", help="write rows as JSON; - for standard output")
    return parser.parse_args()


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Align rows under their keys."""
    if not rows:
        return ""
    keys = list(rows[0])
    cells = [keys] + [[_cell(row.get(key, "")) for key in keys] for row in rows]
    widths = [max(len(line[k]) for line in cells) for k in range(len(keys))]
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
        for line in cells
    )


def _cell(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def main(doc: str, module: str, measure: Callable[[bool], tuple[list[Row], list[Row]]]) -> None:
    """Run `measure(quick)` -> rows, must_show rows; print tables and write JSON where asked."""
    asked = arguments(doc, module)
    rows, bounds = measure(asked.quick)
    stream = sys.stderr if asked.json == "-" else sys.stdout
    print(table(rows), "\n", table(bounds), sep="\n", file=stream)
    if asked.json:
        text = json.dumps({"rows": rows, "must_show": bounds}, indent=1)
        if asked.json == "-":
            print(text)
        else:
            Path(asked.json).write_text(text + "\n")
