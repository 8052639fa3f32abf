"""Commands in processes of their own, fresh or forked; their processor time; what outlives them."""

import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.kills.fork_server import MARK
from benchmarks.kills.processor_time import seconds
from benchmarks.kills.watched import Hit

ROOT = Path(__file__).parents[2]
ORPHANS_GONE = 5.0  # s after a kill
LOOK_EVERY = 0.002  # s between two looks at a process' time
HUNG = 300.0  # s after which a command is ended


@dataclass(frozen=True)
class Command:
    """A command that runs; `ended` returns its exit status, None while it runs."""

    pid: int
    ended: Callable[[], int | None]
    words: Path

    def wait(self, most: float | None = None) -> bool:
        """Wait until it ends, or has taken `most` seconds of processor time; whether it ended."""
        end = time.monotonic() + HUNG
        while self.ended() is None:
            if time.monotonic() > end:
                os.kill(self.pid, signal.SIGKILL)
            if most is not None and seconds(self.pid) >= most:
                return False
            time.sleep(LOOK_EVERY)
        return True

    @property
    def said(self) -> str:
        """The last line that it wrote to standard error."""
        lines = self.words.read_text(errors="replace").strip().splitlines()
        return lines[-1] if lines else "no word"


def environment(mark: str = "") -> dict[str, str]:
    """That of a command."""
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    quiet = {key: value for key, value in os.environ.items() if key != "HANNES_MEASURED"}
    return {**quiet, "PYTHONPATH": path, MARK: mark}


def fresh(folder: Path, arguments: Sequence[str], hit: Hit, mark: str) -> Command:
    """Start a command in a process of its own, as a shell does."""
    words = folder / "words.txt"
    with words.open("wb") as file:
        process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.kills.watched", json.dumps(asdict(hit)), *arguments],
            cwd=folder, env=environment(mark), start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=file,
        )  # fmt: skip
    return Command(process.pid, process.poll, words)


class ForkServer:
    """Starts commands by forking a process that has these modules imported."""

    def __init__(self, modules: Sequence[str]) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.kills.fork_server"],
            env=environment(), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip
        self._write(json.dumps(list(modules)))

    def _write(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()

    def _read(self) -> int:
        assert self._process.stdout is not None
        return int(self._process.stdout.readline())

    def _answered(self) -> bool:
        assert self._process.stdout is not None
        return bool(select.select([self._process.stdout], [], [], 0.0)[0])

    def start(self, folder: Path, arguments: Sequence[str], hit: Hit, mark: str) -> Command:
        """Start a command; only once the one before has ended."""
        words = folder / "words.txt"
        words.write_bytes(b"")  # a process may be killed before it writes
        order = {"folder": str(folder), "mark": mark, "hit": asdict(hit), "words": str(words)}
        self._write(json.dumps({**order, "arguments": list(arguments)}))
        pid, status = self._read(), list[int]()

        def ended() -> int | None:
            if not status and self._answered():
                status.append(self._read())
            return status[0] if status else None

        return Command(pid, ended, words)

    def close(self) -> None:
        """End it."""
        self._process.communicate()


def orphans(pid: int, mark: str) -> list[int]:
    """Processes that a command, the leader of its session, started and that outlive it.

    They are of its session, or have its mark in the environment that they were started with.
    """
    found, sign = [], f"{MARK}={mark}".encode()
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, IndexError):
            state, _, _, session = (place / "stat").read_text().rpartition(")")[2].split()[:4]
            if state != "Z" and (
                int(session) == pid or sign in (place / "environ").read_bytes().split(b"\0")
            ):
                found.append(int(place.name))
    return found


def gone(pid: int, mark: str) -> bool:
    """Whether all that a command started has ended in time."""
    end = time.monotonic() + ORPHANS_GONE
    while time.monotonic() < end:
        if not orphans(pid, mark):
            return True
        time.sleep(0.1)
    return not orphans(pid, mark)
