"""What must be in the benchmark: every function that opens or reads a file, every ending and verb.

Readers are known by what they do, not by their names alone: whatever calls something that opens
files is one. None is believed to be covered: those that run while the entries read their sound
files are seen.
"""

import ast
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import hannes
from benchmarks.hostile.readers import Reader
from hannes.core.errors import BadInput

PACKAGE = Path(hannes.__file__).parent
NAMED = re.compile(r"(read|load|open|from)(_\w+)?")
BOUNDED = "hannes.core.io.bounded"
# What opens a file, by the name that is called: of bounded.py, of Python, of libraries.
OPENERS = {"opened", "blocks", "lines", "read_lines", "read_bytes", "require_regular", "open",
           "read_text", "File", "loadmat", "connect", "ZipFile", "AnyReader",
           "ParquetFile"}  # fmt: skip
# Endings that share a reader with another one, which stands for them.
ALIKE = {".hdf5", ".hdf", ".he5", ".ndjson", ".xlsm"}
# What opens or is named so and reads no file of a stranger, by function or module, and why.
NO_READERS = {
    "hannes.bench.dynamometer_live": "opens a device",
    "hannes.bench.export_c": "reads C that ships",
    "hannes.bench.panel.page": "reads a page that ships",
    "hannes.bench.port": "reads a port",
    "hannes.bench.raw_log:RawLogWriter.__init__": "writes",
    "hannes.bench.virtual_board": "reads a port",
    "hannes.campaigns.third_party": "reads checksums that ship",
    "hannes.commands.edge": "opens the null device",
    "hannes.commands.reproduce": "reads what `diagnose` wrote",
    "hannes.core.io.atomic_files": "writes",
    "hannes.core.io.bounded:_without_waiting": "is called by Python's own open",
    "hannes.core.io.locks": "opens locks of its own",
    "hannes.core.io.unit_factors": "reads a cache of its own",
    "hannes.core.kernels": "reads a cache of its own",
    "hannes.core.recording.hdf5:dump": "writes",
    "hannes.core.trust.consent:forget": "reads what was remembered",
    "hannes.core.trust.loader:load": "runs Python that was consented to",
    "hannes.dataset.hdf5_file": "writes, and reads what it wrote",
    "hannes.dataset.make": "reads a cache of its own",
    "hannes.dynamics.gear_load:load_loss": "is the loss of a gear",
    "hannes.identification.confusability": "reads a table that ships",
    "hannes.recognition.model_file:write": "writes",
    "hannes.report.paper.table_3": "reads what `evaluate` wrote into its own folder",
    "hannes.report.viewer.page": "reads a page that ships",
    "hannes.simulation.compiler": "reads equations, and a cache of its own",
    "hannes.simulation.experiment.shipped:question": "reads a file that ships",
}


def readers() -> tuple[str, ...]:
    """Functions of the package that open a file or are named as readers are, module:name."""
    return _readers_of(PACKAGE)


@cache
def _readers_of(package: Path) -> tuple[str, ...]:
    return tuple(
        f"{_module(path)}:{name}"
        for path in sorted(package.rglob("*.py"))
        for name, node in _functions(ast.parse(path.read_text(encoding="utf-8")))
        if NAMED.fullmatch(node.name) or any(map(_opens, ast.walk(node)))
    )


def _functions(tree: ast.AST, above: str = "") -> Iterator[tuple[str, ast.FunctionDef]]:
    """Functions of a module, and methods of its classes, with their names."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            yield above + node.name, node
        elif isinstance(node, ast.ClassDef):
            yield from _functions(node, f"{above}{node.name}.")


def _opens(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call):
        return False
    called = node.func
    name = getattr(called, "id", None) or getattr(called, "attr", None)
    return name in OPENERS


def _module(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts).removesuffix(".__init__")


def excused(name: str) -> bool:
    """Whether a function, its module or a package above it is among NO_READERS."""
    module, _, _ = name.partition(":")
    parts = module.split(".")
    above = {".".join(parts[: k + 1]) for k in range(len(parts))}
    return bool({name, *above} & set(NO_READERS))


def missing(covered: set[str]) -> list[str]:
    """Readers that no entry of the benchmark covers, and that are not excused either."""
    return [each for each in readers() if each not in covered and not excused(each)]


def covered(entries: Iterable[Reader], folder: Path) -> set[str]:
    """Functions of the package, module:name, that run while entries read their sound files."""
    called: set[CodeType] = set()

    def seen(frame: FrameType, event: str, given: Any) -> None:
        called.add(frame.f_code)

    for each in entries:
        path = folder / f"mutant{each.ending}"
        path.write_bytes(each.seed())
        sys.setprofile(seen)
        try:
            with suppress(BadInput):
                each.use(path)
        finally:
            sys.setprofile(None)
            path.unlink()
    return {_name(code) for code in called if Path(code.co_filename).is_relative_to(PACKAGE)}


def _name(code: CodeType) -> str:
    return f"{_module(Path(code.co_filename))}:{code.co_qualname}"


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
