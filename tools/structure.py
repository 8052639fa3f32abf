"""How the package is built, and the limits it keeps: `python -m tools.structure`.

Prints each figure beside its limit and ends with status 1 where one is passed.
"""

import ast
import statistics
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "hannes"
BESIDES = {"__init__.py", "__main__.py", "py.typed", "__pycache__"}
MOST_ENTRIES, MOST_LINES, LONGEST_FUNCTION, MEDIAN_FUNCTION = 13, 300, 50, 10
EXHAUSTIVE = ("hannes", "hannes.simulation")  # packages whose parts a contract has to order
EQUATIONS = "hannes/simulation/hand/equations.py"  # the model in one file, however long
DOCSTRINGS = "D100,D101,D102,D103,D104"  # of modules, classes, methods, functions, packages


@dataclass(frozen=True)
class Finding:
    """One figure of the structure: what it says, and what passes its limit."""

    text: str
    beyond: list[str] = field(default_factory=list)


def entries(package: Path = PACKAGE) -> Finding:
    """Files and folders of the package's root; `bench` may come on top of the limit."""
    found = sorted(each.name for each in package.iterdir() if each.name not in BESIDES)
    limit = MOST_ENTRIES + ("bench" in found)
    text = f"{len(found)} entries in {package.name}/, at most {limit}: {', '.join(found)}"
    return Finding(text, [] if len(found) <= limit else found)


def imports(package: str = PACKAGE.name) -> dict[str, set[str]]:
    """Which modules each module imports, anywhere in it and for type checking too."""
    import grimp

    graph = grimp.build_graph(package, exclude_type_checking_imports=False, cache_dir=None)
    return {each: graph.find_modules_directly_imported_by(each) for each in graph.modules}


def circles(graph: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """Groups of modules that reach one another."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    names = sorted(graph)
    place = {name: k for k, name in enumerate(names)}
    edges = [(place[one], place[other]) for one in names for other in graph[one]]
    rows, columns = np.array(edges, dtype=int).reshape(-1, 2).T
    matrix = coo_matrix((np.ones(rows.size), (rows, columns)), (len(names), len(names)))
    count, group = connected_components(matrix, connection="strong")
    members = [[names[k] for k in np.flatnonzero(group == each)] for each in range(count)]
    return [each for each in members if len(each) > 1]


def cycles() -> Finding:
    """Import cycles, imports for type checking counted."""
    graph = imports()
    found = [" <-> ".join(each) for each in circles(graph)]
    count = sum(map(len, graph.values()))
    text = f"{len(found)} import cycles among {len(graph)} modules and {count} imports, at most 0"
    return Finding(text, found)


def contract(settings: Mapping[str, Any]) -> Finding:
    """The import contract orders every part of both levels, and keeps siblings apart."""
    layers = {
        container: each
        for each in settings["contracts"]
        if each["type"] == "layers"
        for container in each["containers"]
    }
    beyond = [
        f"{each}: no exhaustive contract"
        for each in EXHAUSTIVE
        if not layers.get(each, {}).get("exhaustive")
    ]
    beyond += [
        f"{container}: {row}, whose parts may import each other (write | between them)"
        for container, each in layers.items()
        for row in each["layers"]
        if ":" in row
    ]
    if settings.get("exclude_type_checking_imports"):
        beyond.append("imports for type checking are not counted")
    rows = ", ".join(f"{len(layers[each]['layers'])} layers in {each}" for each in layers)
    return Finding(f"import contract: {rows}; every part has its layer", beyond)


def import_contract() -> Finding:
    """The contract as it stands in pyproject.toml; `make lint` checks it."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        return contract(tomllib.load(file)["tool"]["importlinter"])


def sources(package: Path = PACKAGE) -> Iterator[tuple[str, str]]:
    """Path, from the folder above the package, and text of each module."""
    for path in sorted(package.rglob("*.py")):
        yield path.relative_to(package.parent).as_posix(), path.read_text(encoding="utf-8")


def lengths(text: str) -> Iterator[tuple[int, str]]:
    """Lines, from `def` to the last one, and name of every function in a module's text."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.end_lineno - node.lineno + 1, node.name  # type: ignore[operator]


def functions() -> Finding:
    """How long functions are, docstrings counted."""
    found = [(count, f"{path}:{name}") for path, text in sources() for count, name in lengths(text)]
    median, longest = statistics.median(count for count, _ in found), max(found)
    beyond = [f"{name}: {count} lines" for count, name in found if count > LONGEST_FUNCTION]
    if median >= MEDIAN_FUNCTION:
        beyond.append(f"the median: {median:g} lines")
    text = (
        f"{len(found)} functions: median {median:g} lines, below {MEDIAN_FUNCTION}; longest "
        f"{longest[0]} ({longest[1]}), at most {LONGEST_FUNCTION}"
    )
    return Finding(text, beyond)


def files() -> Finding:
    """How long files are."""
    found = sorted((text.count("\n"), path) for path, text in sources())
    beyond = [
        f"{path}: {count} lines"
        for count, path in found
        if count > MOST_LINES and path != EQUATIONS
    ]
    count, path = max(each for each in found if each[1] != EQUATIONS)
    whole = sum(count for count, _ in found)
    text = (
        f"{len(found)} files, {whole} lines: longest {count} ({path}), at most {MOST_LINES} but "
        f"for the {dict(map(reversed, found))[EQUATIONS]} of {EQUATIONS}"
    )
    return Finding(text, beyond)


def docstrings() -> Finding:
    """Public modules, classes, methods and functions without a docstring, as ruff finds them."""
    command = [sys.executable, "-m", "ruff", "check", "--isolated", f"--select={DOCSTRINGS}"]
    command += ["--output-format=concise", "--quiet", str(PACKAGE)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    beyond = [line for line in done.stdout.splitlines() if ": D" in line]
    if done.returncode and not beyond:
        beyond = [f"ruff: {done.stderr.strip()}"]
    return Finding(f"{len(beyond)} public names without a docstring, at most 0", beyond)


CHECKS = (entries, cycles, import_contract, functions, files, docstrings)


def main() -> int:
    """Print every figure; 1 where a limit is passed."""
    failed = False
    for check in CHECKS:
        found = check()
        failed |= bool(found.beyond)
        print(found.text)
        for each in found.beyond:
            print(f"    beyond the limit: {each}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
