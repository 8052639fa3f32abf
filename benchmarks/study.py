"""Long studies: one line of JSON for each case, so that what was done is never done twice."""

import argparse
import hashlib
import importlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from tqdm import tqdm

from hannes.core.io.atomic_files import write_text

Case = tuple[str, int]  # kind and seed


def parser(name: str, doc: str | None) -> argparse.ArgumentParser:
    """Options that every study has; name: of its module."""
    made = argparse.ArgumentParser(
        prog=f"python -m benchmarks.{name}",
        description=doc,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument("--quick", action="store_true", help="few cases, for a first look")
    made.add_argument("--resume", action="store_true", help="keep the cases already measured")
    made.add_argument("--show", action="store_true", help="measure nothing")
    made.add_argument("--cases", type=Path, metavar="FILE", help="a line for each case")
    made.add_argument("--most", type=int, metavar="N", help="the first N cases alone")
    made.add_argument("--workers", type=int, default=1, help="processes, one a core (1)")
    made.add_argument("--json", metavar="FILE", help="write rows as JSON; - for standard output")
    return made


def run(
    file: Path,
    cases: Sequence[Case],
    measure: Callable[[str, int], dict[str, Any]],
    resume: bool,
    workers: int = 1,
) -> list[dict[str, Any]]:
    """Results of all cases in their order; lines already in `file` are kept where `resume`.

    workers: processes; `measure` is then a function of a module.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    if not resume:
        file.unlink(missing_ok=True)
    _mend(file)
    done = {(row["kind"], row["seed"]): row for row in read(file)}
    left = [case for case in cases if case not in done]
    for (kind, seed), found in tqdm(_measured(left, measure, workers), "cases", len(left)):
        row = {"kind": kind, "seed": seed, **found}
        with file.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(row) + "\n")
        done[(kind, seed)] = row
    return [done[case] for case in cases]


def _mend(file: Path) -> None:
    """Take off what a killed study left of a last line, so that the next begins one."""
    text = file.read_text(encoding="utf-8") if file.exists() else ""
    if text and not text.endswith("\n"):
        write_text(file, text[: text.rfind("\n") + 1])


def _measured(
    cases: Sequence[Case], measure: Callable[[str, int], dict[str, Any]], workers: int
) -> Iterator[tuple[Case, dict[str, Any]]]:
    """Cases with what was measured of them, as they end."""
    if workers == 1:
        yield from ((case, measure(*case)) for case in cases)
        return
    context = get_context("spawn")
    started = context.Value("i", 0)
    with ProcessPoolExecutor(workers, context, _on_a_core, (started,)) as pool:
        running = {pool.submit(measure, *case): case for case in cases}
        try:
            for future in as_completed(running):
                yield running[future], future.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _on_a_core(started: Any) -> None:
    """Keep this process on a core of its own: the threads of one case do not wait for another's.

    started: how many processes came before
    """
    if not hasattr(os, "sched_setaffinity"):
        return
    with started.get_lock():
        number, started.value = started.value, started.value + 1
    cores = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cores[number % len(cores)]})


def read(file: Path) -> Iterable[dict[str, Any]]:
    """Whole lines of a file; what a killed study left of its last one is passed over."""
    if not file.exists():
        return
    text = file.read_text(encoding="utf-8")
    for line in text.splitlines(keepends=True):
        if line.endswith("\n"):
            yield json.loads(line)


@cache
def code(*packages: str) -> str:
    """Digest of the sources of packages, or of modules: other code makes another study."""
    digest = hashlib.sha256()
    for package in packages:
        found = importlib.import_module(package)
        whole = [Path(home) for home in getattr(found, "__path__", ())]
        files = [file for home in whole for file in sorted(home.rglob("*.py"))]
        for file in files or [Path(str(found.__file__))]:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]
