"""The verbs that are killed, and what they read: all of it takes a few seconds to be worked on."""

import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.kills.processes import ROOT, fresh
from benchmarks.kills.watched import Hit

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
    run = fresh(folder, arguments, Hit(), "")
    run.wait()
    if run.ended():
        raise SystemExit(f"hannes {' '.join(arguments)}: {run.said}")
