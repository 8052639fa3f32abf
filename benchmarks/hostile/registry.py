"""What must be in the benchmark: every public reader, every ending, every verb."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import hannes

PACKAGE = Path(hannes.__file__).parent
NAMED = re.compile(r"(read|load|open|from)(_\w+)?")
# Functions of such a name that read no file of a stranger, and why.
NO_READERS = {
    "hannes.report.paper.table_3:read": "reads what `evaluate` wrote into its own folder",
    "hannes.simulation.compiler.open_channels:open_channels": "reads equations",
    "hannes.simulation.compiler.entry_points:read_ahead": "reads a table in memory",
    "hannes.dynamics.gear_load:load_loss": "is the loss of a gear",
    "hannes.core.trust.loader:load": "runs Python that was consented to",
    "hannes.core.io.bounded:read_bytes": "opens for all others",
    "hannes.campaigns.foreign.text_columns:Delimited.read": "of a source that is open",
    "hannes.bench.port:Port.read": "reads a port",
}


def readers() -> Iterator[str]:
    """Public functions of the package that are named as readers are, module:name."""
    for path in sorted(PACKAGE.rglob("*.py")):
        module = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and NAMED.fullmatch(node.name):
                yield f"{module.removesuffix('.__init__')}:{node.name}"


def missing(covered: set[str]) -> list[str]:
    """Readers that no entry of the benchmark covers, and that are not excused either."""
    return [each for each in readers() if each not in covered and each not in NO_READERS]


def endings() -> set[str]:
    """Endings of foreign files that have a reader."""
    from hannes.campaigns.foreign.sources import READERS

    return set(READERS)


def verbs() -> set[str]:
    """Commands of `hannes`."""
    import argparse

    from hannes.commands.cli import make_parser

    parser = make_parser()
    (commands,) = (x for x in parser._actions if isinstance(x, argparse._SubParsersAction))
    return set(commands.choices)


# Endings that share a reader with another one, which stands for them.
ALIKE = {".hdf5", ".hdf", ".he5", ".ndjson", ".xlsm"}
