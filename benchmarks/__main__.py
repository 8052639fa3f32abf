"""Run the benchmarks and write benchmarks/README.md: `python -m benchmarks [--quick] [NAME ...]`.

Each runs in a process of its own. The page is written when all named by default have run whole.
With --records none runs: the page's parts of those that run for long are written anew.
"""

import argparse
import ast
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.harness import Row, processor, table
from hannes.core.io.atomic_files import write_text

NAMES = ("accuracy_work", "parts", "calls", "processors", "peers", "batch", "start", "recognition")
# These run for long: their `--json` is in records.
RECORDED = ("kills", "hostile", "grip", "link", "intake", "guards", "few_runs")
FOLDER = Path(__file__).parent
PAGE = FOLDER / "README.md"
HEAD = """# Benchmarks

Written by `make bench`, on {machine}. One benchmark alone: `python -m benchmarks.NAME [--quick]
[--json FILE|-]`. A bound holds for the value itself; low and high are its 95 % interval. Ratios
of times differ from one processor to another.
"""


def main() -> int:
    """Run what is asked for; the exit status of the first that fails, else 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer repeats; leaves the page")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}")
    parser.add_argument("--records", action="store_true", help="run none: write what is recorded")
    asked = parser.parse_args()
    if asked.records:
        write_text(PAGE, with_records(PAGE.read_text(encoding="utf-8")))
        return 0
    found: dict[str, Any] = {}
    for name in asked.names or NAMES:
        print(f"\n== {name}", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "found.json"
            command = [sys.executable, "-m", f"benchmarks.{name}", "--json", str(file)]
            status = subprocess.run([*command, *["--quick"] * asked.quick], check=False).returncode
            if status != 0:
                return status
            found[name] = json.loads(file.read_text())
    if not asked.quick and set(NAMES) <= found.keys():
        write_text(PAGE, page(found))
    return 0


def page(found: dict[str, Any]) -> str:
    """Text of the page: of each benchmark what it does, its bounds, its rows."""
    every = {**found, **recorded()}
    parts = (section(name, tables) for name, tables in every.items())
    return "\n".join([HEAD.format(machine=processor()), *parts])


def recorded() -> dict[str, Any]:
    """Rows and bounds of those that run for long, by name."""
    kept = {name: FOLDER / "records" / f"{name}.json" for name in RECORDED}
    return {name: json.loads(file.read_text()) for name, file in kept.items() if file.exists()}


def section(name: str, tables: dict[str, Any]) -> str:
    """The page's part of one benchmark."""
    file = FOLDER / f"{name}.py"
    file = file if file.exists() else FOLDER / name / "__main__.py"
    doc = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8")))
    rows = f"```text\n{table(tables['rows'])}\n```\n"
    return "\n".join([f"## {name}\n\n{doc}\n", markdown(tables["must_show"]), rows])


def with_records(text: str) -> str:
    """The page with its parts of those that run for long as their records have them."""
    head, *parts = (part.rstrip("\n") for part in text.split("\n## "))
    known = {part.partition("\n")[0]: f"## {part}\n" for part in parts}
    known |= {name: section(name, tables) for name, tables in recorded().items()}
    return "\n".join([f"{head}\n", *known.values()])


def markdown(rows: Sequence[Row]) -> str:
    """Bounds as a table in Markdown."""
    lines = ["| what | value | 95 % interval | bound | holds |", "|---|---|---|---|---|"]
    for row in rows:
        spread = f"{row['low']:.4g} to {row['high']:.4g}" if "low" in row else ""
        holds = "yes" if row["holds"] else "**no**"
        lines.append(
            f"| {row['name']} | {row['value']:.4g} | {spread} | {row['bound']:g} | {holds} |"
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
