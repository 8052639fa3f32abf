"""Every verb that writes, killed at many moments: no torn output, no orphan, reruns complete.

Half of the moments are drawn from a command's life, half are before or after one of its calls that
write to the disk or rename (os.fsync, os.replace, os.rename, the exchange of two folders). A third
of the kills each is SIGKILL, SIGTERM and SIGHUP; every other one finds a former result in place.
Each kill is a line in a file of records: what was done is not done again.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import Row, aligned, must_show, table
from hannes.core.io.result_marks import changed, file_verb, folder_mark

ROOT = Path(__file__).parent.parent
SIGNALS = ("SIGKILL", "SIGTERM", "SIGHUP")
ORPHANS_GONE = 5.0  # s after a kill
RERUN_EVERY = 5  # kills
QUICK = 10
MARK = "HANNES_KILLS_RUN"  # in the environment of a command and of all that it starts

# Runs hannes; before or after the call of this number that writes or renames it gets a signal.
WATCHED = """
import os, signal, sys
from pathlib import Path
number, after, name, counted = int(sys.argv[1]), sys.argv[2] == "after", sys.argv[3], sys.argv[4]
del sys.argv[1:5]
calls = 0
def hit():
    os.kill(os.getpid(), getattr(signal, name))
def watched(call):
    def called(*given, **how):
        global calls
        calls += 1
        mine = calls == number
        if mine and not after:
            hit()
        found = call(*given, **how)
        if mine and after:
            hit()
        return found
    return called
for one in ("fsync", "replace", "rename"):
    setattr(os, one, watched(getattr(os, one)))
from hannes.core.io import atomic_files
atomic_files._exchange = watched(atomic_files._exchange)
from hannes.commands.cli import main
status = main()
if counted != "-":
    Path(counted).write_text(str(calls))
sys.exit(status)
"""
RAMP = '[reference]\nkind = "ramp"\npoints = [["0 s", "0 rad"], ["0.3 s", "5 rad"]]\n'
GRASPS = """
seed = 1
duration = "0.7 s"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.4 s", "9 rad"], ["0.65 s", "0 rad"]]
[[grasps]]
name = "{name}"
shape = "sphere"
draws = {draws}
[grasps.values]
"object.radius" = {{ uniform = ["28 mm", "32 mm"] }}
"object.stiffness" = {{ log_uniform = ["300 N/m", "40 kN/m"] }}
"""
MAPPING = """
[time]
column = "t"
unit = "s"
[channels.current]
column = "i"
unit = "A"
[channels.reference]
column = "r"
unit = "rad"
"""


@dataclass(frozen=True)
class Verb:
    """Arguments of a command, and where it writes."""

    name: str
    arguments: tuple[str, ...]
    out: str

    def __iter__(self) -> Iterator[str]:
        return iter((*self.arguments, "--out", self.out))


VERBS = {
    each.name: each
    for each in (
        Verb("run", ("run", "short.toml"), "run"),
        Verb("convert", ("convert", "log.csv", "--mapping", "map.toml"), "converted.csv"),
        Verb("dataset", ("dataset", "set.toml", "--workers", "2"), "set.h5"),
        Verb("train", ("train", "grasps.h5", "--trees", "8"), "model.h5"),
        Verb("evaluate", ("evaluate", "known.h5", "evaluation.toml"), "evaluated"),
        Verb("calibrate", ("calibrate", "campaign.toml", "--trust"), "calibrated"),
        Verb("diagnose", ("diagnose", "campaign.toml", "--trust"), "diagnosed"),
        Verb("reproduce", ("reproduce",), "reproduced"),
    )
}


def prepared(folder: Path, names: Sequence[str]) -> None:
    """Write what the verbs read; all of it takes a few seconds to be worked on."""
    example = ROOT / "examples" / "own_plant"
    for file in example.glob("*.*"):
        shutil.copy(file, folder)
    (folder / "short.toml").write_text('duration = "0.3 s"\n' + RAMP)
    (folder / "set.toml").write_text(GRASPS.format(name="balls", draws=300))
    (folder / "map.toml").write_text(MAPPING)
    rows = [f"{1e-3 * k},{np.sin(0.01 * k):.6f},0" for k in range(2000)]
    (folder / "log.csv").write_text("t,i,r\n" + "\n".join(rows) + "\n")
    (folder / "evaluation.toml").write_text('[[object]]\nclass = "soft"\nfile = "grasp.h5"\n')
    if {"calibrate", "diagnose"} & set(names):
        script = [sys.executable, "record.py", "--runs", "3"]
        subprocess.run(script, cwd=folder, check=True, capture_output=True)
    if {"train", "evaluate"} & set(names):
        hannes(folder, "dataset", "set.toml", "--out", "grasps.h5", "--workers", "1")
        hannes(folder, "dataset", "set.toml", "--grasp", "0", "--out", "grasp.h5")
    if "evaluate" in names:
        hannes(folder, "train", "grasps.h5", "--trees", "8", "--out", "known.h5")


def hannes(folder: Path, *arguments: str) -> None:
    """A command that nobody kills."""
    done = started(folder, arguments)
    printed = done.communicate()[1]
    if done.returncode:
        raise SystemExit(f"hannes {' '.join(arguments)}: {printed}")


def started(
    folder: Path, arguments: Sequence[str], how: Sequence[str] = ("0", "before", "SIGKILL", "-"),
    mark: str = "",
) -> "subprocess.Popen[str]":  # fmt: skip
    """Start a command; `how` it is hit, see WATCHED."""
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    quiet = {key: value for key, value in os.environ.items() if key != "HANNES_MEASURED"}
    return subprocess.Popen(
        [sys.executable, "-c", WATCHED, *how, *arguments],
        cwd=folder,
        env={**quiet, "PYTHONPATH": path, MARK: mark},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def torn(path: Path) -> str:
    """What is wrong with an output: nothing where it is absent, or whole."""
    if not os.path.lexists(path):
        return ""
    if path.is_dir():
        mark = folder_mark(path)
        if mark is None:
            return "a folder of results without its mark"
        missing = [name for name in mark.files if not os.path.lexists(path / name)]
        odd = missing or changed(path, mark)
        return f"{odd[0]} is missing or not as it was written" if odd else ""
    return "" if file_verb(path) else "a file that no verb knows"


def orphans(mark: str) -> list[int]:
    """Processes that a command started and that outlive it."""
    found, sign = [], f"{MARK}={mark}".encode()
    for place in Path("/proc").glob("[0-9]*"):
        try:
            if sign in (place / "environ").read_bytes().split(b"\0"):
                found.append(int(place.name))
        except OSError:
            continue
    return found


def gone(mark: str) -> bool:
    """Whether all that a command started has ended in time."""
    end = time.monotonic() + ORPHANS_GONE
    while time.monotonic() < end:
        if not orphans(mark):
            return True
        time.sleep(0.1)
    return not orphans(mark)


def killed(folder: Path, verb: Verb, number: int, life: float, calls: int) -> Row:
    """Kill a command once; what was left of it."""
    rng = np.random.default_rng([number, sum(verb.name.encode())])
    out, name = folder / verb.out, SIGNALS[number % 3]
    if number % 2 == 0 or verb.name == "dataset":  # which has nothing to do where it is whole
        _emptied(out)
    elif not out.exists():
        hannes(folder, *verb)
    mark = f"{os.getpid()}-{verb.name}-{number}"
    writing = number % 4 < 2 and calls > 0
    moment: Any
    if writing:
        moment = f"{'before' if rng.random() < 0.5 else 'after'} call {rng.integers(1, calls + 1)}"
        when, _, which = moment.split()
        run = started(folder, list(verb), (which, when, name, "-"), mark)
        run.communicate()
    else:
        moment = round(float(rng.uniform(0.0, life)), 3)
        run = started(folder, list(verb), mark=mark)
        try:
            run.communicate(timeout=moment)
        except subprocess.TimeoutExpired:
            run.send_signal(getattr(signal, name))
            run.communicate()
    row: Row = {"verb": verb.name, "number": number, "signal": name, "moment": moment}
    row |= {"status": run.returncode, "torn": torn(out), "orphans": 0 if gone(mark) else 1}
    if number % RERUN_EVERY == RERUN_EVERY - 1:
        again = started(folder, list(verb))
        printed = again.communicate()[1]
        whole = again.returncode == 0 and out.exists() and not torn(out)
        row["rerun"] = "complete" if whole else printed.strip().splitlines()[-1:] or ["no word"]
        _emptied(out)
    return row


def _emptied(out: Path) -> None:
    for each in out.parent.glob(f"{out.name}*"):
        shutil.rmtree(each) if each.is_dir() and not each.is_symlink() else each.unlink()


def life_of(folder: Path, verb: Verb) -> tuple[float, int]:
    """Seconds that a command takes, and its calls that write or rename."""
    hannes(folder, *verb)  # compiles
    _emptied(folder / verb.out)
    counted, begun = folder / "calls.txt", time.perf_counter()
    run = started(folder, list(verb), ("0", "before", "SIGKILL", str(counted)))
    words = run.communicate()[1]
    if run.returncode:
        raise SystemExit(f"{verb.name}: {words}")
    life = time.perf_counter() - begun
    return life, int(counted.read_text())


def all_kills(names: Sequence[str], count: int, records: Path) -> list[Row]:
    """Rows of all kills of these verbs, those on record included."""
    kept = records.read_text().splitlines() if records.exists() else []
    rows = [json.loads(line) for line in kept]
    done = {(row["verb"], row["number"]) for row in rows}
    left = {v: [k for k in range(count) if (v, k) not in done] for v in names}
    wanted = [verb for verb in names if left[verb]]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        prepared(folder, wanted)
        for name in wanted:
            life, calls = life_of(folder, VERBS[name])
            line = f"{name}: {life:.1f} s, {calls} calls that write or rename"
            print(line, file=sys.stderr, flush=True)
            for number in left[name]:
                rows.append(killed(folder, VERBS[name], number, life, calls))
                records.parent.mkdir(parents=True, exist_ok=True)
                with records.open("a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
    return [row for row in rows if row["verb"] in names and row["number"] < count]


def summary(rows: Sequence[Row]) -> tuple[list[Row], list[Row]]:
    """A row a verb, and what must show."""
    found = []
    for name in dict.fromkeys(row["verb"] for row in rows):
        mine = [row for row in rows if row["verb"] == name]
        reruns = [row["rerun"] for row in mine if "rerun" in row]
        found.append({
            "verb": name,
            "kills": len(mine),
            "within writing": sum(isinstance(row["moment"], str) for row in mine),
            "came too late": sum(row.get("status") == 0 for row in mine),
            "torn": sum(bool(row["torn"]) for row in mine),
            "orphans": sum(row["orphans"] for row in mine),
            "reruns": len(reruns),
            "incomplete": sum(each != "complete" for each in reruns),
        })  # fmt: skip
    total = {key: sum(row[key] for row in found) for key in ("torn", "orphans", "incomplete")}
    names = {
        "torn": "outputs torn by a kill",
        "orphans": f"kills that left a process for {ORPHANS_GONE:g} s",
        "incomplete": "reruns that did not complete",
    }
    return found, [must_show(names[key], total[key], 0, total[key] == 0) for key in names]


def main() -> int:
    """Kill, keep records, print the table; exit status 1 where a bound does not hold."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.kills", description=__doc__)
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} kills a verb, nothing kept")
    parser.add_argument("--kills", type=int, default=100, help="of each verb (100)")
    parser.add_argument("--only", nargs="+", choices=VERBS, default=list(VERBS), metavar="VERB")
    parser.add_argument("--records", type=Path, default=Path("results/kills.jsonl"))
    parser.add_argument("--json", type=Path, metavar="FILE", help="write rows as JSON")
    asked = parser.parse_args()
    if asked.quick:
        with tempfile.TemporaryDirectory() as place:
            rows = all_kills(asked.only, QUICK, Path(place) / "kills.jsonl")
    else:
        rows = all_kills(asked.only, asked.kills, asked.records)
    found, bounds = summary(rows)
    print(table(found), "\n", table(aligned(bounds)), sep="\n")
    if asked.json:
        asked.json.write_text(json.dumps({"rows": found, "must_show": bounds}, indent=1) + "\n")
    return 0 if all(each["holds"] for each in bounds) else 1


if __name__ == "__main__":
    sys.exit(main())
