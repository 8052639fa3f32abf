"""A warm grasp compiled at LLVM's levels and for several processors; and beside another checkout.

How a function is cut into calls, and how much these hand on, is LLVM's choice: it must not decide
over the time of a grasp. 200 dynamometer grasps through `simulate_many` on one core at rtol 1e-2,
processor time, all cases in turn. The processor that runs it is named, for ratios differ by it.
Where a process lies in memory costs or saves as much as the code that it runs: each case is the
median of many processes, started in turn, of which none waits beside another.
With `HANNES_BASE=FOLDER` (a checkout with an environment of its own) `beside` compares its time
too, and that of `simulate` at rtol 1e-3; `diagnoses` that of the two diagnoses of `make run`, once
compiled. These take about a minute each: some twenty in all, `--quick` twelve.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from tqdm import tqdm

from benchmarks.harness import (
    ROOT,
    Row,
    aligned,
    interpreter,
    interval,
    main,
    must_show,
    processor,
)

LEVELS = (1, 2, 3)
PARTS = ("levels", "beside", "diagnoses")
INSIDE = 5  # timed repeats within one process
NAMES = ("", "znver2", "skylake-avx512", "haswell")  # of processors; the first one is this one's
Cases = Mapping[str, tuple[Mapping[str, str], Path]]  # environment, and root of a checkout
WORKER = """
import hashlib, os, sys, time
import numpy as np
try:
    from hannes.core.kernels import numba_private
    numba_private.LEVEL = 3
except (ImportError, AttributeError):
    pass
from hannes import Hand, load_experiment, simulate, simulate_many
experiment, hand = load_experiment("dynamometer")[0].experiment, Hand()
stiffness = np.exp(np.random.default_rng(1).uniform(np.log(1e3), np.log(5e4), 200))
how = dict(channels=("current", "force"), sampling=100.0, rtol=1e-2, workers=1, progress=False)

def many():
    digest = hashlib.sha256()
    for grasp in simulate_many(hand, experiment, {"object.stiffness": stiffness}, **how):
        digest.update(np.ascontiguousarray(grasp.require()["current"]).tobytes())
        digest.update(np.ascontiguousarray(grasp["force"]).tobytes())
    return digest.hexdigest()

def one():
    for _ in range(40):
        ran = simulate(hand, experiment, rtol=1e-3).require()
    return hashlib.sha256(ran["current"].tobytes()).hexdigest()

def diagnosed(name):
    from hannes import diagnose
    found = diagnose(os.path.join(os.environ["CAMPAIGNS"], name, "campaign.toml")).verdict
    return hashlib.sha256(repr((found.verdict, found.effects)).encode()).hexdigest()

ways = {"many": (many, 200), "one": (one, 40)}
ways |= {name: (lambda name=name: diagnosed(name), 1) for name in ("hidden-slack", "no-slack")}
for line in sys.stdin:
    run, grasps = ways[line.strip()]
    start = time.process_time()
    digest = run()
    print(1e3 * (time.process_time() - start) / grasps, digest, flush=True)
"""


class Runner:
    """A process that runs grasps when asked, with machine code of its own."""

    def __init__(self, folder: Path, settings: Mapping[str, str], root: Path = ROOT) -> None:
        self.process = subprocess.Popen(
            [interpreter(root), "-c", WORKER],
            cwd=root,
            env={**os.environ, "PYTHONPATH": str(root), "HANNES_CACHE": str(folder), **settings},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self.took: dict[str, list[float]] = {}
        self.digest: dict[str, str] = {}

    def run(self, way: str) -> None:
        """Run grasps in one of the ways of WORKER and note their time [ms]."""
        assert self.process.stdin is not None and self.process.stdout is not None
        print(way, file=self.process.stdin, flush=True)
        took, self.digest[way] = self.process.stdout.readline().split()
        self.took.setdefault(way, []).append(float(took))

    def end(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.wait()


@contextmanager
def runners(cases: Cases) -> Iterator[dict[str, Runner]]:
    """A process for each case, compiled one after the other."""
    with tempfile.TemporaryDirectory() as folder:
        found = {
            name: Runner(Path(folder) / str(n), *case)
            for n, (name, case) in enumerate(cases.items())
        }
        try:
            yield found
        finally:
            for each in found.values():
                each.end()


def turns(found: Mapping[str, Runner], way: str, repeats: int) -> None:
    """Run all in turn, forwards and backwards; once before, to compile."""
    for each in tqdm(found.values(), "compiling", leave=False):
        each.run(way)
        each.took[way].clear()
    for repeat in tqdm(range(repeats), way, leave=False):
        for each in list(found.values())[:: 1 if repeat % 2 else -1]:
            each.run(way)


def one_by_one(cases: Cases, rounds: int) -> tuple[dict[str, float], set[str]]:
    """Median time [ms] of each case over processes of its own, and all digests of results."""
    took: dict[str, list[float]] = {name: [] for name in cases}
    digests = set[str]()
    with tempfile.TemporaryDirectory() as folder:
        for turn in tqdm(range(rounds + 1), "levels", leave=False):  # the first one compiles
            for n, (name, case) in enumerate(cases.items()):
                runner = Runner(Path(folder) / str(n), *case)
                for _ in range(1 + INSIDE if turn else 1):
                    runner.run("many")
                runner.end()
                digests.add(runner.digest["many"])
                took[name] += [float(np.median(runner.took["many"][1:]))] if turn else []
    return {name: float(np.median(each)) for name, each in took.items()}, digests


def levels(quick: bool) -> tuple[list[Row], list[Row]]:
    """Times by level and processor name, over the quickest of them."""
    names, some = NAMES[:2] if quick else NAMES, (1, 2) if quick else LEVELS
    cases = {
        f"{name or 'this one'}, level {level}": (
            {"NUMBA_OPT": str(level), **({"NUMBA_CPU_NAME": name} if name else {})},
            ROOT,
        )
        for name in names
        for level in some
    }
    times, digests = one_by_one(cases, 2 if quick else 9)
    least = min(times.values())
    rows: list[Row] = [
        {"compiled_for": name, "ms_per_grasp": took, "over_quickest": took / least}
        for name, took in times.items()
    ]
    spread = max(times.values()) / least
    return rows, [
        must_show("slowest over quickest of them", spread, 1.15, spread <= 1.15),
        must_show("results that differ in a bit", len(digests) - 1, 0, len(digests) == 1),
    ]


def beside(base: Path, quick: bool) -> tuple[list[Row], list[Row]]:
    """Times over those of another checkout."""
    rows, bounds = list[Row](), list[Row]()
    with runners({"base": ({}, base), "now": ({}, ROOT)}) as found:
        for way, what in (("many", "simulate_many, rtol 0.01"), ("one", "simulate, rtol 0.001")):
            turns(found, way, 7 if quick else 61)
            took = {name: np.array(each.took[way]) for name, each in found.items()}
            over = took["now"] / took["base"]
            row = {"value": float(np.median(over)), **interval(over.tolist())}
            rows.append({"compiled_for": what, "ms_per_grasp": float(np.median(took["now"]))})
            held = row["high"] < 1.02
            bounds.append(must_show(f"{what}, over base", 0.0, 1.02, held) | row)
    return rows, bounds


def diagnoses(base: Path, quick: bool) -> tuple[list[Row], list[Row]]:
    """Times of the two diagnoses of `make run` over those of another checkout, both warm."""
    rows, bounds = list[Row](), list[Row]()
    with tempfile.TemporaryDirectory() as folder:
        campaigns = {"CAMPAIGNS": folder}
        for name, slack in (("hidden-slack", "3 mm"), ("no-slack", "none")):
            write_campaign(Path(folder) / name, slack)
        with runners({"base": (campaigns, base), "now": (campaigns, ROOT)}) as found:
            for name in ("hidden-slack", "no-slack"):
                turns(found, name, 3 if quick else 7)
                took = {each: np.array(found[each].took[name]) for each in found}
                over = took["now"] / took["base"]
                row = {"value": float(np.median(over)), **interval(over.tolist())}
                seconds = 1e-3 * float(np.median(took["now"]))
                rows.append({"diagnosis": name, "s_of_processor": seconds, "pairs": over.size})
                held = row["high"] < 1.05
                bounds.append(must_show(f"diagnosis {name}, over base", 0.0, 1.05, held) | row)
                same = found["now"].digest[name] == found["base"].digest[name]
                bounds.append(must_show(f"diagnosis {name}: other verdicts", not same, 0, same))
    return rows, bounds


def write_campaign(folder: Path, slack: str) -> None:
    """Closures of the independent truth, as `make run` makes them."""
    made = ["--out", str(folder), "--slack", slack, "--runs", "6", "--seed", "1"]
    command = [sys.executable, "-m", "benchmarks.truth.closures", *made]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def measure(quick: bool, only: Sequence[str]) -> tuple[list[Row], list[Row]]:
    """A row for each level and processor name, and for what is compared with another checkout."""
    print(f"processors: {processor()}", file=sys.stderr, flush=True)
    rows, bounds = levels(quick) if "levels" in only else ([], [])
    for name, part in (("beside", beside), ("diagnoses", diagnoses)):
        if (base := os.environ.get("HANNES_BASE")) and name in only:
            more, further = part(Path(base), quick)
            rows, bounds = rows + more, bounds + further
    return aligned(rows), bounds


if __name__ == "__main__":
    main(__doc__, "processors", measure, PARTS)
