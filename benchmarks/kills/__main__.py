"""Every verb that writes, killed at many moments: no torn output, no orphan, reruns complete.

Half of the moments are drawn from a command's processor time, half are before or after one of its
calls that write to the disk or rename (os.fsync, os.replace, os.rename, the exchange of two
folders). A third of the kills each is SIGKILL, SIGTERM and SIGHUP; every other one finds a former
result in place. One in eleven kills a process that starts as a shell starts it, the others one
that is forked where all that it imports is imported. Each kill is a line in a file of records:
what was done is not done again.
"""

import argparse
import json
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from benchmarks.harness import Row, aligned, must_show, table
from benchmarks.kills.one_kill import Known, foreseen, killed, known
from benchmarks.kills.processes import ORPHANS_GONE, ForkServer
from benchmarks.kills.verbs import VERBS, prepared

AT_ONCE = 2  # kills, each in a folder of its own
QUICK = 10
TOO_LATE = 0.2  # a larger share than that: signals do not arrive, or moments are wrong


def all_kills(names: Sequence[str], count: int, records: Path, at_once: int = AT_ONCE) -> list[Row]:
    """Rows of all kills of these verbs, those on record included."""
    kept = records.read_text().splitlines() if records.exists() else []
    rows: list[Row] = [json.loads(line) for line in kept]
    done = {(row["verb"], row["number"]) for row in rows}
    left = {v: [k for k in range(count) if (v, k) not in done] for v in names}
    wanted = [verb for verb in names if left[verb]]
    records.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        first = Path(place) / "0"
        first.mkdir()
        prepared(first, wanted)
        for name in wanted:
            life = known(first, VERBS[name])
            print(_described(name, life), file=sys.stderr, flush=True)
            folders = [first, *(Path(place) / f"{name}-{k}" for k in range(1, at_once))]
            for each in folders[1:]:
                shutil.copytree(first, each)
            parts = [left[name][k::at_once] for k in range(at_once)]
            work = partial(_some, name, life, records, threading.Lock())
            with ThreadPoolExecutor(at_once) as pool:
                for found in pool.map(work, folders, parts):
                    rows += found
            for each in folders[1:]:
                shutil.rmtree(each)
    mine = [row for row in rows if row["verb"] in names and row["number"] < count]
    return sorted(mine, key=lambda row: (names.index(row["verb"]), row["number"]))


def _described(name: str, life: Known) -> str:
    return (
        f"{name}: {life.fresh:.2f} s of processor time, {life.forked:.2f} s once all is imported, "
        f"{life.calls} calls that write or rename"
    )


def _some(
    name: str, life: Known, records: Path, lock: threading.Lock, folder: Path, numbers: list[int]
) -> list[Row]:
    """Kills of these numbers, one after another."""
    rows, server = [], ForkServer(life.modules)
    for number in numbers:
        rows.append(killed(folder, VERBS[name], number, life, server))
        with lock, records.open("a") as file:
            file.write(json.dumps(rows[-1]) + "\n")
    server.close()
    return rows


def summary(rows: Sequence[Row]) -> tuple[list[Row], list[Row]]:
    """A row a verb, and what must show."""
    found = []
    for name in dict.fromkeys(row["verb"] for row in rows):
        mine = [row for row in rows if row["verb"] == name]
        reruns = [row["rerun"] for row in mine if "rerun" in row]
        found.append({
            "verb": name,
            "kills": len(mine),
            "fresh starts": sum(row["fresh"] for row in mine),
            "within writing": sum(isinstance(row["moment"], str) for row in mine),
            "came too late": sum(row["status"] == 0 for row in mine),
            "torn": sum(bool(row["torn"]) for row in mine),
            "orphans": sum(row["orphans"] for row in mine),
            "other ends": sum(not foreseen(row) for row in mine),
            "reruns": len(reruns),
            "incomplete": sum(each != "complete" for each in reruns),
        })  # fmt: skip
    names = {
        "torn": "outputs torn by a kill",
        "orphans": f"kills that left a process for {ORPHANS_GONE:g} s",
        "other ends": "commands that ended otherwise than killed, interrupted or done",
        "incomplete": "reruns that did not complete",
    }
    total = {key: sum(row[key] for row in found) for key in names}
    late = max(row["came too late"] / row["kills"] for row in found)
    bounds = [must_show(names[key], total[key], 0, total[key] == 0) for key in names]
    name = "largest share of a verb's kills that came too late"
    return found, [*bounds, must_show(name, late, TOO_LATE, late <= TOO_LATE)]


def _heard(number: int, frame: object) -> None:
    """Do nothing: under nohup commands would ignore the signal too, as they inherit that."""


def main() -> int:
    """Kill, keep records, print the table; exit status 1 where a bound does not hold."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.kills", description=__doc__)
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} kills a verb, nothing kept")
    parser.add_argument("--kills", type=int, default=100, help="of each verb (100)")
    parser.add_argument("--only", nargs="+", choices=VERBS, default=list(VERBS), metavar="VERB")
    parser.add_argument("--at-once", type=int, default=AT_ONCE, help=f"kills at once ({AT_ONCE})")
    parser.add_argument("--records", type=Path, default=Path("results/kills.jsonl"))
    parser.add_argument("--json", type=Path, metavar="FILE", help="write rows as JSON")
    asked = parser.parse_args()
    signal.signal(signal.SIGHUP, _heard)
    if asked.quick:
        with tempfile.TemporaryDirectory() as place:
            rows = all_kills(asked.only, QUICK, Path(place) / "kills.jsonl", asked.at_once)
    else:
        rows = all_kills(asked.only, asked.kills, asked.records, asked.at_once)
    found, bounds = summary(rows)
    print(table(found), "\n", table(aligned(bounds)), sep="\n")
    if asked.json:
        asked.json.write_text(json.dumps({"rows": found, "must_show": bounds}, indent=1) + "\n")
    return 0 if all(each["holds"] for each in bounds) else 1


if __name__ == "__main__":
    sys.exit(main())
