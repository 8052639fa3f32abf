"""Processor time of a diagnosis over another checkout's, on the same campaigns, in turn.

With `HANNES_BASE=FOLDER` (a checkout; with an environment of its own, where it has one) both
diagnose campaigns of the independent truth: ten single effects and ten pairs by the poor protocol,
five single effects of users who state nothing. They are drawn as `benchmarks.naming` draws its
development cases, on seeds that no set of it has. Kinds take turns; so does who goes first.

Each diagnosis is a fresh process on one thread, with the machine code and byte code of
earlier ones; one that compiled is run again. Its time is that of the diagnosis and of all that this
imports. It is stopped after ten minutes of processor time: the ratio is then at most (the other
checkout) or at least (this one) what the row says. One that fails counts as one that never ends;
a case that the other checkout fails is left out, and counted. Other jobs of the machine cost both:
`busy` is how many ran on average. Rows are kept in results/benchmarks: `--resume` goes on, with the
code that they were had with, and no other.
"""

import json
import math
import os
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import study
from benchmarks.harness import ROOT, Row, given, interpreter, interval, must_show
from benchmarks.naming_study.apart.bench import case, written
from benchmarks.naming_study.apart.kinds import NAMED, first_seed
from benchmarks.naming_study.apart.score import outcome
from hannes.core.errors import BadInput

FOLDER = Path("results/benchmarks")
COUNTS = {"single, poor": 10, "pair, poor": 10, "single, naive": 5}
PART = 50  # of a kind's development seeds: the naming study has those below
STOPPED, MOST = "stopped", 600.0  # what is said after so many seconds of a processor
FAILED = "failed"
BOTH = ("base", "now")
POOR, ALL, LONGEST = 0.5, 1.0 / 3.0, 120.0  # bounds: ratios, and seconds
WORKER = """
import json, os, resource, signal, sys
from hannes import diagnose

def spent():
    both = resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN
    return sum(sum(resource.getrusage(who)[:2]) for who in both)

def put(verdict, effects=(), **more):
    said = {"verdict": verdict, "effects": list(effects), **more, "seconds": spent() - begun}
    print(json.dumps(said), flush=True)

def stop(*_):
    put("stopped")
    os._exit(0)

begun, most = spent(), int(sys.argv[2])
signal.signal(signal.SIGXCPU, stop)
resource.setrlimit(resource.RLIMIT_CPU, (int(begun) + most, int(begun) + most + 60))
try:
    found = diagnose(sys.argv[1], progress=False).verdict
    put(found.verdict, found.effects)
except Exception as failed:
    put("failed", reason=str(failed))
"""


def cases(quick: bool) -> list[study.Case]:
    """Name of kind and seed of every case; kinds take turns."""
    counts = {name: 1 if quick else count for name, count in COUNTS.items()}
    found = [
        ((k + 0.5) / count, (name, first_seed(NAMED[name], "development") + PART + k))
        for name, count in counts.items()
        for k in range(count)
    ]
    return [each for _, each in sorted(found, key=lambda one: one[0])]


def measured(base: Path, name: str, seed: int) -> Row:
    """One case: what is hidden, what both checkouts say, and what it took them."""
    kind = NAMED[name]
    one = case(kind, seed)
    row: Row = {
        "code": study.code("hannes"),
        "hidden": one.hidden.sizes,
        "effects": one.hidden.effects,
    }
    with tempfile.TemporaryDirectory() as folder:
        campaign = written(one.made, kind.stated, Path(folder))
        roots = {"base": base, "now": ROOT}
        for who in BOTH[:: 1 if seed % 2 else -1]:
            row[who] = warm(roots[who], campaign, (FOLDER / f"diagnoses-{who}").absolute())
    return {**row, "busy": os.getloadavg()[1]}


def warm(root: Path, campaign: Path, cache: Path) -> dict[str, Any]:
    """What a checkout says, and what that took without compiling.

    cache: folder of machine code and byte code
    """
    before, said = _machine_code(cache), diagnosed(root, campaign, cache)
    return said if _machine_code(cache) == before else diagnosed(root, campaign, cache)


def _machine_code(cache: Path) -> set[Path]:
    return set((cache / "machine-code").rglob("*"))


def diagnosed(root: Path, campaign: Path, cache: Path) -> dict[str, Any]:
    """Verdict, effects and processor seconds of a checkout's diagnosis, in a process of its own."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(root),
        "HANNES_CACHE": str(cache / "machine-code"),
        "PYTHONPYCACHEPREFIX": str(cache / "byte-code"),  # of packages, too: installers differ
        "PYTHONDONTWRITEBYTECODE": "",
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
    }
    ended = subprocess.run(
        [interpreter(root), "-c", WORKER, str(campaign), str(int(MOST))],
        cwd=root,
        env=environment,
        stdout=subprocess.PIPE,
        check=True,
    )
    return dict(json.loads(ended.stdout.splitlines()[-1]))


def ratio(row: Mapping[str, Any]) -> float:
    """Processor time over the base's: at most that where the base was stopped.

    Infinite where this one was stopped or failed; NaN where the base failed.
    """
    if row["base"]["verdict"] == FAILED:
        return float("nan")
    if row["now"]["verdict"] in (STOPPED, FAILED):
        return float("inf")
    return float(row["now"]["seconds"] / row["base"]["seconds"])


def figures(done: Sequence[Row]) -> tuple[list[Row], list[Row], list[Row]]:
    """A row for each kind, one for each case, and bounds."""
    kinds = {name: [each for each in done if each["kind"] == name] for name in COUNTS}
    kinds = {name: some for name, some in kinds.items() if some}
    asked = {name: POOR for name in kinds if NAMED[name].protocol == "poor"}
    bounds = [bound(name, kinds[name], most) for name, most in asked.items()]
    if done:
        longest = max(_ended(each["now"]) for each in done)
        held = longest <= LONGEST
        bounds.append(bound("all", done, ALL))
        bounds.append(must_show("longest diagnosis, s of processor", longest, LONGEST, held))
    return [_kind(name, some) for name, some in kinds.items()], [_case(e) for e in done], bounds


def _ended(said: Mapping[str, Any]) -> float:
    return float("inf") if said["verdict"] == FAILED else float(said["seconds"])


def bound(name: str, some: Sequence[Row], most: float) -> Row:
    """Median ratio of some cases, but for those that the base failed."""
    ratios = [each for each in map(ratio, some) if not math.isnan(each)]
    left = f" ({len(some) - len(ratios)} left out: base failed)" if len(ratios) < len(some) else ""
    what = f"{name}: processor time over base, median of {len(ratios)}{left}"
    if not ratios:
        return must_show(what, float("nan"), most, False)
    middle = float(np.median(ratios))
    return must_show(what, middle, most, middle <= most) | interval(ratios)


def require_one_code(done: Iterable[Row], file: Path, now: str | None = None) -> None:
    """Raise BadInput where rows were had with several codes, or not all with code `now`."""
    codes = {str(each["code"]) for each in done} | ({now} if now else set())
    if len(codes) > 1:
        raise BadInput(
            f"{file}: cases of codes {', '.join(sorted(codes))}: expected one"
            f"{f', {now}, of this checkout' if now else ''}; name another file with --cases"
        )


def _kind(name: str, some: Sequence[Row]) -> Row:
    row: Row = {"campaigns": name, "cases": len(some)}
    for who in BOTH:
        seconds = [each[who]["seconds"] for each in some]
        ends = [outcome(NAMED[name].what, each[who], each["effects"], None) for each in some]
        row |= {
            f"{who}_s": float(np.median(seconds)),
            f"{who}_longest_s": max(seconds),
            f"{who}_stopped": sum(each[who]["verdict"] == STOPPED for each in some),
            f"{who}_failed": sum(each[who]["verdict"] == FAILED for each in some),
            f"{who}_right": ends.count("right") + ends.count("both"),
        }
    return row


def _case(row: Row) -> Row:
    said = {who: " ".join([row[who]["verdict"], *row[who]["effects"]]) for who in BOTH}
    return {
        "case": f"{row['kind']}, {row['seed']}",
        **{f"{who}_s": row[who]["seconds"] for who in BOTH},
        "ratio": ratio(row),
        "busy": row["busy"],
        "hidden": ", ".join(f"{name} {size:.3g}" for name, size in row["hidden"].items()),
        **said,
    }


def main() -> None:
    """Measure, print tables, write JSON where asked."""
    asked = study.parser("diagnoses", __doc__).parse_args()
    file = asked.cases or FOLDER / "diagnoses.jsonl"
    if asked.show:
        done = list(study.read(file))
    else:
        ask = partial(measured, Path(os.environ["HANNES_BASE"]).resolve())
        if asked.resume:
            require_one_code(study.read(file), file, study.code("hannes"))
        done = study.run(file, cases(asked.quick)[: asked.most], ask, asked.resume, asked.workers)
    require_one_code(done, file)
    rows, each, bounds = figures(done)
    given({"rows": rows, "cases": each, "must_show": bounds}, (rows, each, bounds), asked.json)


if __name__ == "__main__":
    main()
