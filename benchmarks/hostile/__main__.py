"""Hostile files: thousands of structured mutants for every reader and verb, and packed bombs.

readers  each as a library function: only BadInput may come, in one line; no traceback, no crash, no
         Python of the folder or the path run, no file changed, no more than 100 MiB and 16 bytes a
         byte resident, at most four seconds of processor time each
verbs    each through the command line, in one process, 30 s each: exit 70 counts as a traceback
bombs    files that would take gigabytes or never end: each is refused, in how many seconds

Mutants have numbers: the same number is the same mutant in every run. What was done is kept in
results/hostile.jsonl, so that a run that was ended goes on where it was; delete it to begin anew.
"""

import tempfile
from pathlib import Path

from tqdm import tqdm

from benchmarks.harness import Row, main, must_show
from benchmarks.hostile import bombs, verbs
from benchmarks.hostile.readers import Reader, of_data
from benchmarks.hostile.tomls import of_settings
from benchmarks.hostile.verbs import PORT
from benchmarks.hostile.worker import CHUNK, Ends, Ledger, furnished, prepare

LEDGER = Path("results/hostile.jsonl")
MUTANTS, QUICK = 5000, 4
VERB_MUTANTS, VERB_QUICK = 300, 2
PARTS = ("readers", "verbs", "bombs")
PARSED = 0.3  # least share of mutants past the parser


def every_reader() -> list[Reader]:
    """All readers of the package."""
    return [*of_data(), *of_settings()]


def mutated(
    found: list[Reader], count: int, ledger: Ledger, folder: Path, imported: bool = True
) -> tuple[list[Row], list[Ends]]:
    """A row for each reader: how its mutants ended.

    imported: the sound file is read here first, so that processes of mutants begin with all imports
    """
    rows, all_ends = [], []
    step = min(CHUNK * 10, count)
    for reader in tqdm(found, "readers", leave=False, disable=None):
        ends = Ends()
        if imported and not ledger.has(reader, count, step):
            prepare(reader, folder)
        for first in range(0, count, step):
            ends.add(ledger.run(reader, range(first, min(first + step, count)), folder))
        rows.append(
            {
                "reader": reader.name,
                "mutants": ends.count,
                "read": ends.read,
                "refused": ends.refused,
                "past the parser": round(1.0 - (ends.unparsed + len(ends.faults)) / ends.count, 3),
                "wrong": len(ends.faults),
                "the first": f"{ends.faults[0]}"[:120] if ends.faults else "",
            }
        )
        all_ends.append(ends)
    return rows, all_ends


def measure(quick: bool, only: tuple[str, ...] = PARTS) -> tuple[list[Row], list[Row]]:
    """Run the parts; rows, and what must hold."""
    LEDGER.parent.mkdir(exist_ok=True)
    ledger = Ledger(None if quick else LEDGER)
    rows: list[Row] = []
    bounds: list[Row] = []
    with tempfile.TemporaryDirectory() as place:
        folder = furnished(Path(place))
        if "readers" in only:
            found, ends = mutated(every_reader(), QUICK if quick else MUTANTS, ledger, folder)
            rows += found
            wrong = sum(len(each.faults) for each in ends)
            name = f"of {sum(x.count for x in ends)} mutants, neither read nor refused in one line"
            bounds.append(must_show(name, wrong, 0, wrong == 0))
            bounds.append(_least("reader", found))
        if "verbs" in only:
            count = VERB_QUICK if quick else VERB_MUTANTS
            found, ends = mutated(verbs.every_verb(), count, ledger, folder, imported=False)
            rows += found
            wrong = sum(len(each.faults) for each in ends)
            name = f"of {sum(x.count for x in ends)} mutants given to verbs, exit 70 or worse"
            bounds += [must_show(name, wrong, 0, wrong == 0), _least("verb", found)]
            idle = [row["reader"] for row in found if not row["read"] and PORT not in row["reader"]]
            name = f"verbs of which no mutant ran to its end: {', '.join(idle) or 'none'}"
            bounds.append(must_show(name, len(idle), 0, not idle))
        if "bombs" in only:
            found, wrong = bombs.measured(Path(place), quick)
            rows += found
            name = f"of {len(found)} bombs, not refused within their limits"
            bounds.append(must_show(name, wrong, 0, wrong == 0))
    keys = {key: "" for row in rows for key in row}
    return [keys | row for row in rows], bounds


def _least(what: str, rows: list[Row]) -> Row:
    least = min(float(row["past the parser"]) for row in rows)
    name = f"least share of a {what}'s mutants past the parser"
    return must_show(name, least, PARSED, least >= PARSED)


if __name__ == "__main__":
    main(__doc__ or "", "hostile", measure, PARTS)
