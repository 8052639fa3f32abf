"""The commands about many grasps: make a data set, train a classifier on it, evaluate it."""

import argparse
import json
from collections.abc import Callable
from typing import Any

EXAMPLES = {
    "dataset": """\
hannes dataset large                       a shipped one: results/large.h5
hannes dataset my.toml --out my.h5 --workers 4
hannes dataset my.toml --backend dask --scheduler tcp://host:8786
hannes dataset large --grasp 4711 --out grasp.h5

my.toml:
  title = "Balls"
  hand = "hannes"                          # or a hand.toml
  effects = ["leader_slack"]
  seed = 1
  duration = "1.15 s"
  border = "5.5 kN/m"                      # from which an object counts as rigid
  channels = ["reference", "position", "current", "force"]
  [reference]
  kind = "ramp"
  points = [["0 s", "0 rad"], ["0.637 s", "9.84 rad"], ["1.022 s", "0 rad"]]
  [values]                                 # of all groups
  "mcp.*" = { spread = "0.02" }            # the hand's own value times exp(0.02 z)
  "leader_slack.length" = { uniform = ["0 mm", "3 mm"] }
  "command.speed" = ["0.8", "1"]           # levels: every combination is a cell
  "noise.current" = "10 mA"
  "resolution.position" = "1.534 mrad"
  [[grasps]]
  name = "balls"
  shape = "sphere"                         # cylinder, prism; none for an empty hand
  draws = 100                              # grasps of each cell
  role = "train"                           # or "test"
  [grasps.values]
  "object.radius" = { uniform = ["25 mm", "34 mm"] }
  "object.stiffness" = { log_uniform = ["300 N/m", "40 kN/m"] }
A run that was ended goes on where it was when it is started again.""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the commands; `command(name, call, told)` makes the parser of one."""
    dataset = command("dataset", _dataset, "simulate many grasps into one HDF5 file")
    dataset.add_argument("spec", help="a shipped specification's name, or a .toml file")
    dataset.add_argument("--out", metavar="FILE.h5", help="the data set (results/<spec>.h5)")
    dataset.add_argument("--workers", type=int, help="local processes (default: all cores)")
    dataset.add_argument("--backend", default="local", help="local (default) or dask")
    dataset.add_argument("--scheduler", default="", metavar="ADDRESS", help="of a Dask cluster")
    dataset.add_argument(
        "--grasp", type=int, metavar="K", help="only this one, as a recording to --out"
    )
    _json(dataset)


def _json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object, nothing else")


def _dataset(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from hannes.dataset.make import make
    from hannes.dataset.part import recorded
    from hannes.dataset.spec import load_spec

    spec, stem = load_spec(chosen.spec), f"results/{Path(chosen.spec).stem}"
    if chosen.grasp is not None:
        out = chosen.out or f"{stem}-{chosen.grasp}.h5"
        recorded(spec, chosen.grasp).write(out)
        told: dict[str, Any] = {"out": out, "grasp": chosen.grasp}
    else:
        how = {"backend": chosen.backend, "scheduler": chosen.scheduler, "workers": chosen.workers}
        told = make(spec, chosen.out or f"{stem}.h5", **how)
    if chosen.json:
        _print_json(told)
    elif chosen.grasp is not None:
        print(f"wrote {told['out']}")
    else:
        kept = told["parts"] - told["parts_simulated"]
        print(
            f"{told['grasps']} grasps, {told['failed']} of them without an end; "
            f"{kept} of {told['parts']} parts were there already"
        )
        print(f"wrote {told['out']}")


def _print_json(content: Any) -> None:
    print(json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False))
