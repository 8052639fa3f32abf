"""Faults put into sound logs: found, named, mended; and sound logs that are left alone.

Logs of the hand (by the independent truth), of an axis and of a position servo, with and without a
recorded command, are spoiled at three strengths. Strength is what the fault does to a fit: gross
moves a calibrated parameter by over 10 % or adds a residual of five noise floors (linearised, see
consequence.py), middling a third of that, small less; a size that does so is searched. `check` must
find it and name the right kind; the lines that its findings give are added to the mapping, the log
is converted and checked again, and what comes out is compared with the sound log. What a log cannot
show in principle is counted apart, with the reason. Sound logs vary in rate, noise, jitter, gaps,
bits and speed. `--resume` goes on where a study ended.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks import study
from benchmarks.harness import given
from benchmarks.intake import sound, summary
from benchmarks.intake.case import STRENGTHS, case
from benchmarks.intake.log import all_kinds

CASES = Path("results/benchmarks/intake.jsonl")
CODE = ("hannes.campaigns", "hannes.core", "benchmarks.intake", "benchmarks.truth")
EACH, QUICK_EACH = 44, 1  # cases a kind and strength
SOUND, QUICK_SOUND = 1000, 12
FIRST = 100_000  # seeds of the quoted study; development had others
SEPARATOR = " / "


def asked_for(quick: bool, kinds: Sequence[str], first: int) -> list[study.Case]:
    """Cases of the whole study, or of its small form."""
    each, count = (QUICK_EACH, QUICK_SOUND) if quick else (EACH, SOUND)
    cases = [] if kinds else [("sound", first + seed) for seed in range(count)]
    for name, kind in all_kinds().items():
        if kinds and name not in kinds:
            continue
        strengths = list(STRENGTHS) if kind.graded else ["gross"]
        strengths = strengths[:1] if quick else strengths
        for strength in strengths:
            cases += [(f"{name}{SEPARATOR}{strength}", first + seed) for seed in range(each)]
    return sorted(cases, key=lambda each: each[1])  # a study cut short has some of every kind


def measured(kind: str, seed: int) -> dict[str, Any]:
    """One case, by its name."""
    if kind == "sound":
        return sound.case(seed)
    name, _, strength = kind.partition(SEPARATOR)
    return {"fault": name, **case(name, strength, seed)}


def main(words: Sequence[str] | None = None) -> int:
    """Print the tables; exit status 1 where a bound does not hold."""
    asked = _arguments(words)
    file = asked.cases
    cases = asked_for(asked.quick, asked.kinds, 0 if asked.quick else asked.first)
    if asked.so_far:
        done = list(study.read(file))
    else:
        done = study.run(file, cases, measured, asked.resume, asked.workers)
    rows, bounds = summary.figures(done)
    given({"rows": rows, "must_show": bounds}, (rows, bounds), asked.json)
    stream = sys.stderr if asked.json == "-" else sys.stdout
    print(f"code {study.code(*CODE)}, {len(done)} cases", file=stream)
    return 0 if all(each["holds"] for each in bounds) or asked.quick else 1


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.intake",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="a case a kind, for a first look")
    parser.add_argument("--resume", action="store_true", help="keep the cases that are done")
    parser.add_argument("--so-far", action="store_true", help="figures of the cases that are done")
    parser.add_argument("--cases", type=Path, default=CASES, metavar="FILE", help="of results")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="processes")
    parser.add_argument("--first", type=int, default=FIRST, metavar="SEED", help="first seed")
    parser.add_argument("--json", metavar="FILE", help="write rows as JSON; - for standard output")
    parser.add_argument("--kinds", nargs="+", default=[], metavar="NAME", help="these kinds alone")
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(main())
