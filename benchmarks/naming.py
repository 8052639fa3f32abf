"""Naming of effects hidden by the independent truth: right, class, wrong, silent, unknown.

Hands, effects and firmware come from the second implementation (benchmarks/truth); an answer is out
of reach until the verdict is made. --study says which hands:

apart (as it is): every joint is 1 % off for itself. Sizes are log-uniform from twice u, or from the
low end of the effect's range, up to its high end, as many from each third. u is the minimum
detectable size of a likelihood-ratio test that knows the effect (80 % power, 5 % false alarms),
frozen in benchmarks/oracle/fingers_apart.toml. Users state nothing and name the shipped experiments
(naive; u as for poor), or state all and record six void and six dynamometer runs (poor) or sixteen
runs with duty and bus voltage (rich). 150 single effects and settings, 120 sound hands, a quarter
of them with coloured noise of the current, 30 pairs, 12 triples, 24 faults of one finger, 40 of
kinds outside the catalogue, half of them kinds that no development case hides, and 24 hands in
MuJoCo's own laws of contact, wires and dry friction. No answer within 120 s of processor time
counts as wrong, and every case is in its denominator.

alike: the former study; fingers are alike, sizes half to five times u of smallest_detectable.toml.

--machine servo is the study of the geared servo of examples/servo: 80 cases, see
benchmarks/naming_study/servo_study.py.

Methods are developed on the seeds of the set "development"; quoted figures are of the set "quoted",
which goes on where it was ended, and is in benchmarks/records. A study takes hours. Cases of all
kinds take turns, so --show has cases of all kinds at any time. --quick takes some minutes. Times
need an otherwise idle machine (--workers 1) and compiled models:
`python -m tools.compile_ahead hand catalogue`.

  python -m benchmarks.naming --resume --most 20
  python -m benchmarks.naming --only "pair, poor" --resume
  python -m benchmarks.naming --set quoted --show
"""

import argparse
import sys
from pathlib import Path

from benchmarks import study
from benchmarks.harness import given
from benchmarks.naming_study import alike, records, servo_study
from benchmarks.naming_study.apart import study as apart
from benchmarks.naming_study.choice import Study

FOLDER = Path("results/benchmarks")
RECORDS = Path(__file__).parent / "records"  # of quoted sets: hours of work, part of the project
STUDIES = {"apart": apart.STUDY, "alike": alike.STUDY}


def _arguments() -> argparse.Namespace:
    parser = study.parser("naming", __doc__)
    parser.add_argument("--study", choices=STUDIES, default="apart", help="of hands (apart)")
    parser.add_argument("--machine", choices=("hand", "servo"), default="hand", help="(hand)")
    parser.add_argument("--set", choices=("development", "quoted"), default="development",
                        dest="chosen", help="of seeds (development)")  # fmt: skip
    parser.add_argument("--only", metavar="KIND", help='one kind alone, such as "single, poor"')
    asked = parser.parse_args()
    known = chosen_study(asked).kinds
    if asked.only not in (None, *known):
        parser.error(f"--only {asked.only}: expected one of {'; '.join(known)}")
    return asked


def chosen_study(asked: argparse.Namespace) -> Study:
    """The study that was asked for."""
    return servo_study.STUDY if asked.machine == "servo" else STUDIES[asked.study]


def kept(asked: argparse.Namespace) -> Path:
    """The file with a line for each case."""
    folder = RECORDS if asked.chosen == "quoted" and not asked.quick else FOLDER
    return folder / f"{chosen_study(asked).named(asked.chosen, asked.quick)}.jsonl"


def main() -> None:
    """Measure, print tables, write JSON where asked."""
    asked = _arguments()
    chosen, file = chosen_study(asked), asked.cases or kept(asked)
    if asked.show:
        # As they were measured, with --cases of any set.
        done = [row for row in records.read(file) if asked.only in (None, row["kind"])]
    else:
        wanted = [c for c in chosen.cases(asked.chosen, asked.quick) if asked.only in (None, c[0])]
        resume = asked.resume or file.parent == RECORDS
        done = records.run(file, wanted[: asked.most], chosen.measured, resume, asked.workers)
    if len({case.get("code") for case in done}) > 1:
        print("not all cases are of the same code; --resume kept them", file=sys.stderr)
    found, tables = chosen.tables(done)
    given({"cases": file.name, **found}, tables, asked.json)


if __name__ == "__main__":
    main()
