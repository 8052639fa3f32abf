"""Start: seconds from the command line to its end, and memory, of fresh processes.

Cold is the first run on a machine, with an empty folder of machine code: it compiles the model;
warm is every later one. What is compared runs in turn, repeated; seconds are medians, by the
clock and of the processor. Intervals are 95 % (bootstrap over repeats). The peak memory of a
process is never reported below that of this one, which starts it.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from benchmarks.harness import Row, interval, main, must_show

RUN = "hannes run dynamometer"
COMMANDS = {
    "python, nothing else": ("-c", "pass"),
    "import hannes": ("-c", "import hannes"),
    "hannes --help": ("-m", "hannes", "--help"),
    RUN: ("-m", "hannes", "run", "dynamometer", "--out"),
}
# Seconds by the clock within which a warm start answers.
MOST = {"import hannes": 0.1, "hannes --help": 0.2, RUN: 1.5}


@dataclass(frozen=True)
class Spent:
    """What a fresh process took: seconds by the clock, of the processor, peak memory."""

    seconds: float
    processor: float
    mib: float


def spent(name: str, cache: Path) -> Spent:
    """Run a command in a fresh process."""
    environment = {**os.environ, "HANNES_CACHE": str(cache), "OMP_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder:
        command = [*COMMANDS[name], *([f"{folder}/out"] if name == RUN else [])]
        clock = time.perf_counter()
        started = subprocess.Popen(
            [sys.executable, *command],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        said = started.stderr.read()
        _, status, used = os.wait4(started.pid, 0)
        seconds = time.perf_counter() - clock
    started.returncode = os.waitstatus_to_exitcode(status)
    if started.returncode != 0:
        raise RuntimeError(f"{name} ended with {started.returncode}: {said.decode()}")
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return Spent(seconds, used.ru_utime + used.ru_stime, used.ru_maxrss / unit)


def row(name: str, found: list[Spent]) -> Row:
    """A line of the table; the spread is the range over repeats."""
    seconds = [each.seconds for each in found]
    return {
        "start": name,
        "seconds": statistics.median(seconds),
        "spread_s": max(seconds) - min(seconds),
        "processor_s": statistics.median(each.processor for each in found),
        "peak_MiB": max(each.mib for each in found),
        "repeats": len(found),
    }


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Cold runs first, each with a folder of its own; then all warm ones in turn."""
    cold: list[Spent] = []
    warm: dict[str, list[Spent]] = {name: [] for name in COMMANDS}
    with tempfile.TemporaryDirectory() as folder:
        for repeat in tqdm(range(1 if quick else 3), "cold starts", leave=False):
            cold.append(spent(RUN, Path(folder) / str(repeat)))
        for _ in tqdm(range(3 if quick else 11), "warm starts", leave=False):
            for name in COMMANDS:
                warm[name].append(spent(name, Path(folder) / "0"))
    rows = [row(f"{RUN}, cold: compiles the model", cold)]
    rows += [row(name if name != RUN else f"{RUN}, warm", found) for name, found in warm.items()]
    return rows, [bound(name, warm[name]) for name in MOST]


def bound(name: str, found: list[Spent]) -> Row:
    """Whether a warm start answers in time."""
    seconds = [each.seconds for each in found]
    value = statistics.median(seconds)
    return must_show(f"{name}, warm: seconds", value, MOST[name], value <= MOST[name]) | interval(
        seconds
    )


if __name__ == "__main__":
    main(__doc__, "start", measure)
