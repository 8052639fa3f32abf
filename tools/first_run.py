"""`make run`: a first diagnosis, the paper's experiments, then recognition; pages in results/.

Steps that do not need each other run at once, on two cores or more. What a command prints stands
behind the time and the step's name. A step that fails ends the others.
"""

import os
import queue
import shlex
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass

CORES = max(2, os.cpu_count() or 2)


@dataclass(frozen=True)
class Step:
    """A Python module with its arguments, run when `cores` are free (0: at once) after others.

    `page`: what can be opened when it has ended, in words.
    """

    name: str
    command: str
    after: tuple[str, ...] = ()
    cores: int = 1
    page: str = ""


DIAGNOSES = "--slack results/hidden-slack --taut results/no-slack"
STEPS = (
    Step("model with all effects", "tools.compile_ahead catalogue"),
    Step("model of the hand", "tools.compile_ahead hand"),
    Step(
        "hidden slack",
        "hannes diagnose examples/closures/campaign.toml --out results/hidden-slack",
        cores=0,  # it waits for the models
        page="results/hidden-slack/report.html: a hidden effect, named",
    ),
    Step(
        "first page",
        "hannes reproduce --out results/reproduce --slack results/hidden-slack "
        "--coming emps recognition",
        ("hidden slack",),
        page="results/reproduce/index.html: the paper's experiments beside the paper",
    ),
    Step("model that floats", "tools.compile_ahead floating", ("hidden slack",)),
    Step(
        "taut closures",
        "benchmarks.truth.closures --runs 6 --seed 1 --out results/taut-closures --slack none",
        ("hidden slack",),
    ),
    Step(
        "no slack",
        "hannes diagnose results/taut-closures/campaign.toml --out results/no-slack",
        ("taut closures",),
    ),
    Step("grasps", "hannes dataset large --out results/large.h5", ("first page",)),
    Step(
        "ten objects",
        "benchmarks.truth.objects --out results/ten-objects --grasps 10 --seed 1",
        ("no slack",),
    ),
    Step(
        "classifier", "hannes train results/large.h5 --out results/large-model.h5", ("grasps",), 2
    ),
    Step(
        "rigid or soft",
        "hannes evaluate results/large-model.h5 results/ten-objects/evaluation.toml "
        "--out results/rigid-or-soft --learning-curve results/large.h5 "
        "--baselines results/large.h5",
        ("classifier", "ten objects"),
        2,
        "results/rigid-or-soft/report.html: ten objects, recognised",
    ),
    Step(
        "whole page",
        f"hannes reproduce --out results/reproduce {DIAGNOSES} --recognition results/rigid-or-soft",
        ("rigid or soft", "no slack"),
        page="results/reproduce/index.html: all of it",
    ),
)


class Run:
    """Steps at work, and what they print."""

    def __init__(self, steps: Sequence[Step], cores: int = CORES) -> None:
        self.left = {each.name: each for each in steps}
        self.cores = self.free = cores
        self.began = time.monotonic()
        self.working: dict[str, tuple[Step, subprocess.Popen[str]]] = {}
        self.readers: list[threading.Thread] = []
        self.done: set[str] = set()
        self.printed: queue.Queue[tuple[str, str | None]] = queue.Queue()

    def __call__(self) -> int:
        """Run all; 0, or the exit status of the step that failed."""
        try:
            while self.left or self.working:
                self._start()
                name, line = self.printed.get()
                if line is not None:
                    self._say(name, line)
                elif status := self._ended(name):
                    return status
        finally:
            self._end()
        return 0

    def _start(self) -> None:
        for each in list(self.left.values()):
            if self.done >= set(each.after) and self._needs(each) <= self.free:
                self.free -= self._needs(each)
                del self.left[each.name]
                self._say(each.name, "begins")
                process = subprocess.Popen(
                    [sys.executable, "-m", *shlex.split(each.command)],
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    text=True,
                    env={**os.environ, "PYTHONUNBUFFERED": "1"},
                )
                self.working[each.name] = each, process
                reader = threading.Thread(target=self._read, args=(each.name, process), daemon=True)
                self.readers.append(reader)
                reader.start()

    def _needs(self, each: Step) -> int:
        return min(each.cores, self.cores)

    def _read(self, name: str, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        with process.stdout:
            for line in process.stdout:
                self.printed.put((name, line.rstrip()))
        self.printed.put((name, None))

    def _ended(self, name: str) -> int:
        each, process = self.working.pop(name)
        status = process.wait()
        self.free += self._needs(each)
        self.done.add(name)
        if status:
            self._say(name, f"ended with status {status}")
        elif each.page:
            self._say(name, f"open {each.page}")
        return status

    def _say(self, name: str, line: str) -> None:
        print(f"{time.monotonic() - self.began:4.0f} s  {name}: {line}", flush=True)

    def _end(self) -> None:
        for _, process in self.working.values():
            process.send_signal(signal.SIGTERM)
        for _, process in self.working.values():
            process.wait()
        for reader in self.readers:
            reader.join(10.0)


def main() -> int:
    """Exit status 0, or that of the step that failed."""
    return Run(STEPS)()


if __name__ == "__main__":
    sys.exit(main())
