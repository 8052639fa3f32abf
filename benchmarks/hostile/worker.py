"""Gives mutants to a reader within a process of its own, under limits of memory and time."""

import hashlib
import json
import multiprocessing
import os
import re
import resource
import signal
import sys
import time
import warnings
import zlib
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.hostile import nasty
from benchmarks.hostile.readers import Reader
from hannes.core.errors import BadInput, ComputationFailed

LOOK = 5.0  # s without a mutant after which a process is looked at
BEYOND = 60.0  # s of processor time, beyond a reader's own, after which it counts as hung
STILL = 600.0  # s without a mutant after which it counts as hung, however little it computes
ABOVE, A_BYTE = 100 << 20, 16  # bytes resident: above what was held before, and a byte decoded
ADDRESSES = 3 << 30  # bytes of address space above that
CHUNK = 100  # mutants between two looks at the folder
# What refusals say where a file is not even one of its kind.
NOT_PARSED = re.compile(
    r"is not valid TOML|cannot be read|not utf-8|not UTF-8|is no JSON|is no MATLAB|no raw log|"
    r"holds a NUL|is not UTF-8"
)
CANARY = "with open({mark!r}, 'a') as file:\n    file.write('ran')\nPLANT = EFFECT = X = None\n"


class _Late(BaseException):
    """The mutant took too long."""


@dataclass
class Ends:
    """How mutants of one reader ended; `faults`: number and what happened, for the wrong ones."""

    read: int = 0
    refused: int = 0
    unparsed: int = 0
    faults: list[tuple[int, str]] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Mutants in all."""
        return self.read + self.refused + len(self.faults)

    def add(self, other: "Ends") -> None:
        """Take those of another in."""
        self.read += other.read
        self.refused += other.refused
        self.unparsed += other.unparsed
        self.faults += other.faults


def rng_of(reader: Reader, number: int) -> np.random.Generator:
    """Random numbers of one mutant: the same in every run."""
    return np.random.default_rng([zlib.crc32(reader.name.encode()), number])


def mutated(reader: Reader, data: bytes, number: int) -> bytes:
    """A mutant; bytes changed where the structured change cannot be written down."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return reader.mutate(data, rng_of(reader, number))
    except Exception:
        return nasty.octets(data, rng_of(reader, number))


def furnished(folder: Path) -> Path:
    """A folder with the files that mutants name, canaries, and where their marks would be."""
    from benchmarks.hostile.tomls import furnish

    work, path = folder / "work", folder / "path"
    work.mkdir()
    path.mkdir()
    mark = str(folder / "RAN")
    for name in ("canary", "queue", "sitecustomize", "h5py", "finger", "conftest"):
        (work / f"{name}.py").write_text(CANARY.format(mark=mark))
    (path / "canary_on_path.py").write_text(CANARY.format(mark=mark))
    furnish(work)
    os.mkfifo(work / "pipe")
    return work


def digest(folder: Path) -> str:
    """Of the names and contents of all files below a folder but the mutant."""
    found = hashlib.sha256()
    for place in sorted(folder.rglob("*")):
        if not place.name.startswith("mutant"):
            found.update(f"{place} {place.stat().st_mode}\n".encode())
            found.update(place.read_bytes() if place.is_file() else b"")
    return found.hexdigest()


def prepare(reader: Reader, folder: Path) -> str:
    """Read the sound file here, so that all is imported; why it is refused, "" where it is not."""
    path = folder / f"mutant{reader.ending}"
    path.write_bytes(reader.seed())
    try:
        reader.use(path)
    except BadInput as error:
        return str(error) if reader.sound else ""
    finally:
        path.unlink(missing_ok=True)
    return ""


def run(reader: Reader, numbers: range, folder: Path) -> Ends:
    """Give the mutants of these numbers to a reader; those that kill or hang it count, too."""
    ends, first = Ends(), numbers.start
    context = multiprocessing.get_context("fork")
    while first < numbers.stop:
        here, there = context.Pipe(duplex=False)
        process = context.Process(
            target=_work, args=(reader, range(first, numbers.stop), folder, there)
        )  # no daemon: verbs start processes of their own
        process.start()
        there.close()
        first = _followed(here, process, ends, first, reader.seconds)
    return ends


def _followed(pipe: Connection, process: Any, ends: Ends, first: int, seconds: float) -> int:
    """Take what a process reports until it ends; return the number of the next mutant."""
    why = "hung"
    while _heard(pipe, process.pid, seconds + BEYOND):
        try:
            report = pipe.recv()
        except EOFError:
            process.join()
            why = f"killed it ({process.exitcode})"
            if process.exitcode == 0:
                return first
            break
        ends.add(report)
        first += report.count
    process.kill()
    process.join()
    ends.faults.append((first, why))
    return first + 1


def _heard(pipe: Connection, pid: int, seconds: float) -> bool:
    """Wait for a report; False where none comes in so much processor time, or in STILL.

    On a machine with other work a minute passes in which a process hardly runs.
    """
    spent, late = _spent(pid), time.monotonic() + STILL
    while not pipe.poll(LOOK):
        if _spent(pid) > spent + seconds or time.monotonic() > late:
            return False
    return True


def _spent(pid: int) -> float:
    """Processor time of a process so far [s]; of children only those that have ended."""
    with suppress(OSError):
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
    return 0.0


def _work(reader: Reader, numbers: range, folder: Path, pipe: Connection) -> None:
    os.chdir(folder)
    sys.path.append(str(folder.parent / "path"))
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    data = reader.seed()
    path = folder / f"mutant{reader.ending}"
    if refusal := prepare(reader, folder):
        pipe.send(Ends(faults=[(k, f"the sound file: {refusal}"[:200]) for k in numbers]))
        return
    signal.signal(signal.SIGPROF, _late)
    _limit_addresses()
    before = digest(folder)
    for number in numbers:
        mutant = mutated(reader, data, number)
        path.write_bytes(mutant)
        ends = Ends()
        _end(ends, number, reader, path, len(mutant))
        if (folder.parent / "RAN").exists():
            (folder.parent / "RAN").unlink()
            ends.faults.append((number, "ran Python of the folder"))
        if number % CHUNK == CHUNK - 1 or number == numbers.stop - 1:
            if digest(folder) != before:
                ends = Ends(faults=[(number, "changed the folder, it or one of those before")])
                before = digest(folder)
        pipe.send(ends)
    path.unlink()


def _late(number: int, frame: Any) -> None:
    raise _Late


def _limit_addresses() -> None:
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + ADDRESSES, size + ADDRESSES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _end(ends: Ends, number: int, reader: Reader, path: Path, size: int) -> None:
    held = _resident("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    signal.setitimer(signal.ITIMER_PROF, reader.seconds)
    fault, refusal = "", None
    try:
        reader.use(path)
    except BadInput as error:
        refusal = str(error)
    except ComputationFailed as error:
        refusal = str(error)
    except _Late:
        fault = f"took more than {reader.seconds} s"
    except BaseException as error:
        fault = f"{type(error).__name__}: {error}"[:200]
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    grown = _resident("VmHWM") - held
    if not fault and grown > ABOVE + A_BYTE * size:
        fault = f"took {grown >> 20} MiB for {size} bytes"
    if not fault and refusal is not None and "\n" in refusal:
        fault = f"refused in several lines: {refusal[:200]}"
    if fault:
        ends.faults.append((number, fault))
    elif refusal is None:
        ends.read += 1
    else:
        ends.refused += 1
        ends.unparsed += bool(NOT_PARSED.search(refusal))


def _resident(what: str) -> int:
    """Bytes that this process has resident, or has had at most."""
    status = Path("/proc/self/status").read_text()
    place = status.index(what) + len(what) + 1
    return int(status[place : status.index("kB", place)]) << 10


class Ledger:
    """What was done, a line a chunk: a benchmark that was ended goes on where it was."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.known: dict[tuple[str, int, int], Ends] = {}
        if path is not None and path.exists():
            for line in path.read_text().splitlines():
                row = json.loads(line)
                key = (row.pop("reader"), row.pop("first"), row.pop("last"))
                self.known[key] = Ends(**row)

    def has(self, reader: Reader, count: int, step: int) -> bool:
        """Whether all mutants of a reader up to `count` are known, in steps."""
        firsts = range(0, count, step)
        return all((reader.name, k, min(k + step, count)) in self.known for k in firsts)

    def run(self, reader: Reader, numbers: range, folder: Path) -> Ends:
        """Of these mutants, known or run now."""
        key = (reader.name, numbers.start, numbers.stop)
        if key not in self.known:
            self.known[key] = ends = run(reader, numbers, folder)
            row = {"reader": key[0], "first": key[1], "last": key[2], **vars(ends)}
            if self.path is not None:
                with self.path.open("a") as file:
                    file.write(json.dumps(row) + "\n")
        return self.known[key]
