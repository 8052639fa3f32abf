"""One kill of one verb: what was left of its output, and of its processes."""

import json
import os
import shutil
import signal
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.harness import Row
from benchmarks.kills.processes import Command, ForkServer, fresh, gone
from benchmarks.kills.verbs import Verb
from benchmarks.kills.watched import Hit
from hannes.core.io.result_marks import changed, file_verb, folder_mark

SIGNALS = ("SIGKILL", "SIGTERM", "SIGHUP")
RERUN_EVERY = 5  # kills
FRESH_EVERY = 11  # kills: in a process that starts as a shell starts it
FORMER = "former"  # results of an undisturbed run, beside where they are written

Start = Callable[[Path, Sequence[str], Hit, str], Command]


@dataclass(frozen=True)
class Known:
    """Of an undisturbed command: calls that write or rename, modules, processor time [s].

    `forked` counts from the fork, `fresh` from the start of Python.
    """

    calls: int
    modules: tuple[str, ...]
    fresh: float
    forked: float


def known(folder: Path, verb: Verb) -> Known:
    """Run a verb undisturbed, and keep its results aside."""
    out = folder / verb.out
    run_whole(fresh, folder, verb)  # compiles
    emptied(out)
    alone = run_whole(fresh, folder, verb)
    for each in out.parent.glob(f"{out.name}*"):
        copied(each, folder / FORMER / each.name)
    emptied(out)
    server = ForkServer(alone["modules"])
    forked = run_whole(server.start, folder, verb)
    server.close()
    return Known(alone["calls"], tuple(alone["modules"]), alone["seconds"], forked["seconds"])


def run_whole(start: Start, folder: Path, verb: Verb) -> Row:
    """Run a verb to its end; return what is noted of it."""
    note = folder / "note.json"
    run = start(folder, list(verb), Hit(note=str(note)), "")
    run.wait()
    if run.ended():
        raise SystemExit(f"{verb.name}: {run.said}")
    found: Row = json.loads(note.read_text())
    return found


def killed(folder: Path, verb: Verb, number: int, life: Known, server: ForkServer) -> Row:
    """Kill a verb once; what was left of it."""
    rng = np.random.default_rng([number, sum(verb.name.encode())])
    out, name = folder / verb.out, SIGNALS[number % 3]
    emptied(out)
    if number % 2 and verb.name != "dataset":  # which has nothing to do where it is whole
        for each in (folder / FORMER).glob(f"{out.name}*"):
            copied(each, folder / each.name)
    alone = number % FRESH_EVERY == 0
    start: Start = fresh if alone else server.start
    mark = f"{os.getpid()}-{verb.name}-{number}"
    row: Row = {"verb": verb.name, "number": number, "signal": name, "fresh": alone}
    if number % 4 < 2:
        hit = Hit(int(rng.integers(1, life.calls + 1)), str(rng.choice(["before", "after"])), name)
        row["moment"] = f"{hit.when} call {hit.number}"
        run = start(folder, list(verb), hit, mark)
        run.wait()
    else:
        row["moment"] = float(rng.uniform(0.0, life.fresh if alone else life.forked))
        run = start(folder, list(verb), Hit(), mark)
        if not run.wait(row["moment"]):
            with suppress(ProcessLookupError):
                os.kill(run.pid, getattr(signal, name))
            run.wait()
    row |= {"status": run.ended(), "said": run.said, "torn": torn(out)}
    row["orphans"] = 0 if gone(run.pid, mark) else 1
    if number % RERUN_EVERY == RERUN_EVERY - 1:
        again = start(folder, list(verb), Hit(), "")
        again.wait()
        whole = again.ended() == 0 and out.exists() and not torn(out)
        row["rerun"] = "complete" if whole else again.said
    return row


def foreseen(row: Row) -> bool:
    """Whether a command ended as one that was killed, interrupted, or not reached any more.

    Python ends itself by SIGINT (130 in a shell) if it was interrupted within a text that it runs,
    as named tuples are made.
    """
    number = getattr(signal, row["signal"])
    orderly = (0,) if row["signal"] == "SIGKILL" else (0, 130, -signal.SIGINT)
    return row["status"] in (*orderly, -number)


def torn(path: Path) -> str:
    """What is wrong with an output: nothing where it is absent, or whole."""
    if not os.path.lexists(path):
        return ""
    if path.is_dir():
        mark = folder_mark(path)
        if mark is None:
            return "a folder of results without its mark"
        missing = [name for name in mark.files if not os.path.lexists(path / name)]
        odd = missing or changed(path, mark)
        return f"{odd[0]} is missing or not as it was written" if odd else ""
    return "" if file_verb(path) else "a file that no verb knows"


def emptied(out: Path) -> None:
    """Remove an output, what stands beside it, and what killed commands left."""
    for each in (*out.parent.glob(f"{out.name}*"), *out.parent.glob(".*")):
        shutil.rmtree(each) if each.is_dir() and not each.is_symlink() else each.unlink()


def copied(source: Path, target: Path) -> None:
    """Copy a file or folder."""
    target.parent.mkdir(exist_ok=True)
    copy = shutil.copytree if source.is_dir() else shutil.copy2
    copy(source, target)
