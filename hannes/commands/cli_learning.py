"""The commands about many grasps: make a data set, train a classifier on it, evaluate it."""

import argparse
from collections.abc import Callable
from typing import Any

from hannes.commands.cli_output import add_force, add_json, print_json
from hannes.commands.cli_trust import add_trust

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
  shape = "sphere"                         # or cylinder, prism, none (an empty hand)
  draws = 100                              # grasps of each cell
  role = "train"                           # or "test"
  [grasps.values]
  "object.radius" = { uniform = ["25 mm", "34 mm"] }
  "object.stiffness" = { log_uniform = ["300 N/m", "40 kN/m"] }
  # cylinders and prisms also lean: "object.tilt_x" = { uniform = ["-15 deg", "15 deg"] }
A run that was ended goes on where it was when it is started again.""",
    "train": """\
hannes train results/large.h5                      writes results/large-model.h5
hannes train results/large.h5 --out model.h5 --trees 640 --seed 3
hannes train results/large.h5 --window "80 ms" --json""",
    "evaluate": """\
hannes evaluate model.h5 evaluation.toml
hannes evaluate model.h5 grasp.h5                  rigid or soft, how stiff, how hard
hannes evaluate model.h5 evaluation.toml --out results/evaluation --json
hannes evaluate model.h5 evaluation.toml --learning-curve results/large.h5
hannes evaluate model.h5 evaluation.toml --baselines results/large.h5

evaluation.toml, whose recordings have the force, by which contact and release are found:
  title = "My objects"
  [[object]]
  name = "Ball"
  class = "soft"                           # or "rigid"
  file = "ball-*.h5"                       # one or more grasps of it
  stiffness = "800 N/m"                    # where it is known""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the commands; `command(name, call, description)` makes the parser of one."""
    dataset = command("dataset", _dataset, "simulate many grasps into one HDF5 file")
    dataset.add_argument("spec", help="a shipped specification's name, or a .toml file")
    dataset.add_argument("--out", metavar="FILE.h5", help="the data set (results/<spec>.h5)")
    dataset.add_argument(
        "--workers", type=int, help="number of local processes (default: all cores)"
    )
    dataset.add_argument(
        "--backend", default="local", help="where grasps run: local (default) or dask"
    )
    dataset.add_argument(
        "--scheduler", default="", metavar="ADDRESS", help="address of a Dask cluster"
    )
    dataset.add_argument(
        "--grasp", type=int, metavar="K", help="only grasp number K, counted from 0, as a recording"
    )
    add_trust(dataset)
    add_force(dataset)
    add_json(dataset)

    _add_models(command)


def _add_models(command: Callable[..., argparse.ArgumentParser]) -> None:
    train = command("train", _train, "train rigid or soft, stiffness and force on a data set")
    train.add_argument("dataset", help="a data set made by `hannes dataset`")
    train.add_argument("--out", metavar="MODEL.h5", help="the model (<dataset>-model.h5)")
    train.add_argument("--trees", type=int, help="number of bagged trees (default 320)")
    train.add_argument("--leaf", type=int, default=0, metavar="N",
                       help="fewest windows in a leaf (2, of class and stiffness 8)")  # fmt: skip
    train.add_argument("--seed", type=int, default=0, help="seed of all random draws (default 0)")
    train.add_argument("--window", default="50 ms", metavar="TIME", help="span of a window (50 ms)")
    train.add_argument("--hop", default="10 ms", metavar="TIME", help="between windows (10 ms)")
    add_force(train)
    add_json(train)

    evaluate = command("evaluate", _evaluate, "score a model on recordings, or apply it to one")
    evaluate.add_argument("model", help="a model made by `hannes train`")
    evaluate.add_argument("recordings", help="an evaluation.toml, or one recording")
    evaluate.add_argument("--out", metavar="FOLDER", help="folder for the page and evaluation.json")
    evaluate.add_argument(
        "--learning-curve",
        metavar="DATASET.h5",
        help="also score models trained on more and more of these grasps (about a minute)",
    )
    evaluate.add_argument(
        "--baselines",
        metavar="DATASET.h5",
        help="also score a look-up of current, by these grasps, and an analytic estimate",
    )
    add_force(evaluate)
    add_json(evaluate)


def _dataset(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from hannes.core.errors import BadInput
    from hannes.core.io.outputs import reserved
    from hannes.core.recording.marked import results_at, write_marked
    from hannes.dataset.make import make
    from hannes.dataset.shard import recorded
    from hannes.dataset.spec import load_spec

    spec, stem = load_spec(chosen.spec), f"results/{Path(chosen.spec).stem}"
    if chosen.grasp is not None:
        if chosen.backend != "local" or chosen.scheduler or chosen.workers:
            raise BadInput("--grasp makes one, here: leave out --backend, --scheduler, --workers")
        out = chosen.out or f"{stem}-{chosen.grasp}.h5"
        with reserved("dataset", results_at(out, "dataset"), spec.inputs, force=chosen.force):
            write_marked(recorded(spec, chosen.grasp), out, "dataset")
        result: dict[str, Any] = {"out": out, "grasp": chosen.grasp}
    else:
        how = {"backend": chosen.backend, "scheduler": chosen.scheduler, "workers": chosen.workers}
        result = make(spec, chosen.out or f"{stem}.h5", force=chosen.force, **how)
    if chosen.json:
        print_json(result)
    elif chosen.grasp is not None:
        print(f"wrote {result['out']}")
    else:
        kept = result["shards"] - result["shards_simulated"]
        print(
            f"{result['grasps']} grasps, {result['failed']} of them without an end; "
            f"{kept} of {result['shards']} shards were there already"
        )
        print(f"wrote {result['out']}")


def _train(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from hannes.core.errors import BadInput
    from hannes.core.io.outputs import reserved
    from hannes.core.io.units import quantity
    from hannes.recognition import model_file
    from hannes.recognition.train import TREES, train
    from hannes.recognition.windowing import Windowing

    trees = TREES if chosen.trees is None else chosen.trees
    if not 1 <= trees <= 2000:
        raise BadInput(f"--trees {trees}: expected 1 to 2000")
    if not 0 <= chosen.leaf <= 10_000:
        raise BadInput(f"--leaf {chosen.leaf}: expected 0 to 10000")
    windowing = Windowing(
        quantity(chosen.window, "s", "--window"), quantity(chosen.hop, "s", "--hop")
    )
    out = chosen.out or str(Path(chosen.dataset).with_suffix("")) + "-model.h5"
    if not out.lower().endswith((".h5", ".hdf5")):
        raise BadInput(f"--out {out}: expected a file named .h5 or .hdf5 for the model")
    with reserved("train", [out], [chosen.dataset], force=chosen.force):
        model, result = train(
            chosen.dataset, trees=trees, seed=chosen.seed, windowing=windowing, leaf=chosen.leaf
        )
        model_file.write(out, model)
    if chosen.json:
        print_json({"out": out, **result})
        return
    print(f"trained on {result['grasps']} grasps of {result['title']}")
    for key, words in (
        ("unseen_scores", "grasps, each by trees that had not seen it"),
        ("test_scores", "held-back grasps"),
    ):
        if found := result.get(key):
            print(
                f"  {found['grasps']} {words}: {100 * found['windows_right']:.1f} % of windows and "
                f"{100 * found['grasps_right']:.1f} % of grasps right"
            )
    if "pressed_error_percent" in result:
        error = result["pressed_error_percent"]
        known = result.get("pressed_error_percent_hand_known")
        more = f"; {known:.1f} % where an empty closure shows the hand" if known else ""
        said = f"{error:.1f} % off, of unseen ones{more}"
        print(f"  stiffness of pressed objects near the border: {said}")
    print(f"wrote {out}")


def _evaluate(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from hannes.commands.evaluate import further, write
    from hannes.core.errors import BadInput
    from hannes.core.io.inputs import noted
    from hannes.core.io.outputs import require_free, reserved
    from hannes.core.recording.recording import Recording
    from hannes.recognition import model_file
    from hannes.recognition.evaluate import evaluate, prediction_of, read_subjects

    targets = [chosen.out] if chosen.out else []
    of_grasps = (chosen.learning_curve, chosen.baselines)
    given = [each for each in (chosen.model, chosen.recordings, *of_grasps) if each]
    for out in targets:
        require_free("evaluate", out, given, folder=True, force=chosen.force)
    model = model_file.read(chosen.model)
    if not chosen.recordings.endswith(".toml"):
        if chosen.out or any(of_grasps):
            raise BadInput(
                f"{chosen.recordings}: --out, --learning-curve and --baselines are for an "
                "evaluation.toml"
            )
        result = prediction_of(model, Recording.read(chosen.recordings))
        print_json(result) if chosen.json else print(_grasp(result))
        return
    with noted() as inputs:
        title, subjects = read_subjects(chosen.recordings)
    inputs |= set(map(Path, given))
    with reserved("evaluate", targets, inputs, folder=True, force=chosen.force):
        result = {"title": title, "trained": model.trained, **evaluate(model, subjects)}
        result |= further(model, subjects, *of_grasps)
        if chosen.out:
            write(chosen.out, result, chosen.force)
    if chosen.json:
        print_json(result)
        return
    print(_scores(result))
    if chosen.out:
        print(f"open {chosen.out}/report.html")


def _grasp(result: dict[str, Any]) -> str:
    lines = [f"{result['decision']} (probability of rigid {result['rigid']:.2f})"]
    for key, words in (("stiffness", "stiffness"), ("peak_force", "peak grip force")):
        if each := result[key]:
            ends = f"{each['low']:.3g} to {each['high']:.3g}"
            lines.append(f"  {words} {each['value']:.3g} {each['unit']} (95 %: {ends})")
    if result["peak_force"] is None:
        lines.append(
            "  no contact in the current, so neither stiffness nor grip force is estimated"
        )
    return "\n".join(lines)


def _scores(result: dict[str, Any]) -> str:
    lines = [result["title"], f"  {'object':<20} class   F1 windows  F1 grasps  stable in time"]
    lines += [
        f"  {row['name']:<20} {row['class']:<6} {100 * row['f1_windows']:10.1f} % "
        f"{100 * row['f1_grasps']:8.1f} % {100 * row['stable_in_time']:12.0f} %"
        for row in result["objects"]
    ]
    lines.append(
        f"  {'average':<27} {100 * result['f1_windows']:10.1f} % "
        f"{100 * result['f1_grasps']:8.1f} % {100 * result['stable_in_time']:12.0f} %"
    )
    lines += [
        f"  {words:<27} {100 * row['f1_windows']:10.1f} % {100 * row['f1_grasps']:8.1f} %"
        for words, row in _simpler(result)
    ]
    lines += [
        f"  {row['grasps']:>8} grasps trained   {100 * row['f1_windows']:10.1f} % "
        f"{100 * row['f1_grasps']:8.1f} % {100 * row['stable_in_time']:12.0f} %"
        for row in result.get("learning_curve", ())
    ]
    named = (("force", "peak force"), ("stiffness", "stiffness"))
    lines += [_estimates(words, result[key]) for key, words in named if result[key]["answered"]]
    error = 100 * result["reliability"]["calibration_error"]
    lines.append(f"  probabilities are off by {error:.1f} points on average")
    return "\n".join(lines)


def _simpler(result: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    words = {"look_up": "a look-up of current", "analytic": "an analytic estimate"}
    return [(words[name], row) for name, row in result.get("baselines", {}).items()]


def _estimates(words: str, result: dict[str, Any]) -> str:
    middle = result["median_error_percent"]
    off = "beyond measure" if middle is None else f"by {middle:.1f} %"
    return (
        f"  {words}: off {off} (median); "
        f"estimated for {result['answered']} of {result['grasps']} grasps, "
        f"95 % intervals hold {100 * result['interval_holds']:.1f} % of all"
    )
