"""Training and evaluating on `large`, beside another checkout: processor time, and the figures.

With `HANNES_BASE=FOLDER` (a checkout; with an environment of its own, where it has one) both run
`hannes train` and `hannes evaluate`, with learning curve and simpler ways, on the same data set and
the same recordings of the ten objects. Processor time is that of whole commands and of all that
they start, compiled before. Each model is scored by the code of its checkout, and by its
independent truth, of which the seeds must be the same. F1 has its 95 % interval over grasps, force
errors theirs: what is learnt faster must lie within the other's. Coverage is of the 95 % intervals
of the peak force, on ninety objects drawn at random too.

Takes a quarter of an hour of processor time for the other checkout. Without one this checkout's
figures alone. `--quick` uses `large` with a tenth of its grasps. Files stay in results/recognition.
"""

import json
import os
import resource
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.harness import ROOT, Row, aligned, interpreter, main, must_show
from benchmarks.recognition import OUT, build
from benchmarks.recognition_rows import errors
from benchmarks.truth import objects
from hannes.core.io.atomic_files import write_text

MOST = 0.25  # of the other checkout's processor time
SEED = 1  # of the recordings that `hannes evaluate` reads
FIGURES = ("f1_windows", "f1_grasps", "f1_worst")
SCORED = """
import json, sys
from benchmarks.recognition import spread, strangers, subjects
from hannes.recognition import model_file
from hannes.recognition.evaluate import evaluate

model, quick = model_file.read(sys.argv[1]), sys.argv[2] == "quick"
chosen = subjects(quick)
found = {
    "scores": evaluate(model, chosen),
    "interval": spread(model, chosen),
    "drawn": evaluate(model, strangers(quick)),
}
print(json.dumps(found, default=float))
"""


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Rows of each checkout; bounds where there is another."""
    OUT.mkdir(parents=True, exist_ok=True)
    data = OUT / ("large-part.h5" if quick else "large.h5")
    if not data.exists():
        build("large", 0.1 if quick else 1.0)
    asked = recorded(3 if quick else 10)
    base = os.environ.get("HANNES_BASE")
    roots = {**({"base": Path(base)} if base else {}), "now": ROOT}
    found = {name: learnt(name, root, data, asked, quick) for name, root in roots.items()}
    return aligned([row(name, each) for name, each in found.items()]), bounds(found)


def recorded(grasps: int) -> Path:
    """The evaluation.toml of the ten objects, recorded where it is missing."""
    folder = OUT / f"ten-objects-{grasps}"
    if not (folder / "evaluation.toml").exists():
        for name, recording in objects.make(grasps, SEED).items():
            recording.write(folder / f"{name}.h5")
        write_text(folder / "evaluation.toml", objects.evaluation(objects.things()))
    return folder / "evaluation.toml"


def learnt(name: str, root: Path, data: Path, asked: Path, quick: bool) -> dict[str, Any]:
    """Processor seconds of a checkout's two commands, and the figures of its model."""
    model = OUT / f"learning-{name}.h5"
    model.unlink(missing_ok=True)
    command(root, "evaluate", "--help")
    seconds = {"train_s": command(root, "train", str(data), "--out", str(model))}
    more = [str(asked), "--learning-curve", str(data), "--baselines", str(data)]
    command(root, "evaluate", str(model), str(asked))  # compiles
    seconds["evaluate_s"] = command(root, "evaluate", str(model), *more)
    size = "quick" if quick else "whole"
    said = python(root, "-c", SCORED, str(model), size, stdout=subprocess.PIPE).stdout
    return seconds | json.loads(said.splitlines()[-1])


def command(root: Path, *words: str) -> float:
    """Run a command of a checkout; processor seconds of it and of what it started."""
    before = children()
    python(root, "-m", "hannes", *words, stdout=subprocess.DEVNULL)
    return children() - before


def python(root: Path, *words: str, stdout: int) -> subprocess.CompletedProcess[str]:
    """Run Python on a checkout's code, in its environment and this folder."""
    return subprocess.run(
        [interpreter(root), "-P", *words],  # -P: else this folder's own hannes
        cwd=Path.cwd(),
        env={**os.environ, "PYTHONPATH": str(root)},
        stdout=stdout,
        text=True,
        check=True,
    )


def children() -> float:
    """Processor seconds of all processes that have ended."""
    return sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


def row(name: str, found: Mapping[str, Any]) -> Row:
    """One checkout's times and figures."""
    scores, drawn = found["scores"], found["drawn"]
    force = scores["force"]
    return {
        "checkout": name,
        "train_s": found["train_s"],
        "evaluate_s": found["evaluate_s"],
        **{f"{key}_%": 100 * scores[key] for key in FIGURES},
        "force_off_%": force["median_error_percent"],
        "force_holds_%": 100 * force["interval_holds"],
        "drawn_off_%": drawn["force"]["median_error_percent"],
        "drawn_holds_%": 100 * drawn["force"]["interval_holds"],
        "stiffness_off_%": drawn["stiffness"]["median_error_percent"],
        "stiffness_holds_%": 100 * drawn["stiffness"]["interval_holds"],
    }


def bounds(found: Mapping[str, Any]) -> list[Row]:
    """Processor time over the base's; every figure within the base's 95 % interval."""
    if "base" not in found:
        return []
    base, now = found["base"], found["now"]
    spent = {name: each["train_s"] + each["evaluate_s"] for name, each in found.items()}
    ratio = spent["now"] / spent["base"]
    rows = [must_show("processor time of both commands over base", ratio, MOST, ratio <= MOST)]
    for key in FIGURES:
        ends, value = base["interval"][key], 100 * now["scores"][key]
        rows.append(must_show(f"{key}, %, base's lower end", value, ends["low"],
                              value >= ends["low"]) | ends)  # fmt: skip
    for name, which in (("ten objects", "scores"), ("objects drawn", "drawn")):
        ends, value = errors(base[which]["force"]), now[which]["force"]["median_error_percent"]
        rows.append(must_show(f"peak force off, {name}, %, base's upper end", value,
                              ends["high"], value <= ends["high"]) | ends)  # fmt: skip
    held = 100 * now["drawn"]["force"]["interval_holds"]
    rows.append(must_show("95 % interval of the peak force holds, objects drawn, %", held, 90.0,
                          90.0 <= held <= 98.0))  # fmt: skip
    return rows


if __name__ == "__main__":
    main(__doc__, "learning", measure)
