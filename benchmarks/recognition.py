"""Recognition: rigid or soft, how stiff and how hard, from current, position and reference alone.

Training data are simulated grasps only, from shipped data sets. The bounds are for `large`.
`eighteen` is the paper's design, and `seated` knows the bench. The test data are the ten objects of
Fig. 4 as the independent truth grasps them: other hands, each with a slack leader and a gear with
load-dependent loss, and sensor noise. `large` and `seated` draw both effects, more widely;
`eighteen` has neither.

Windows count from contact to release, at 5 % of the peak force. A decision is in time where it is
right from 150 ms after contact until release. A grasp without contact counts as not decided,
without an estimate, and outside its interval. Intervals are 95 % (bootstrap over grasps).

Coverage of the peak force is measured on ninety random objects too, a third of them prisms. It is
over all grasps with an estimate. The rows also have the coverage over the ten objects alone: their
errors are correlated within an object, which cannot separate 98 from 100 %.

Other rows: trainings with other seeds, the value of a diagnosis, MuJoCo's rollout, runs that were
killed or ran out of disk, a cluster, damaged files, a held grasp. Intermediate files stay in
results/recognition.
"""

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import fuzzed, killed, rollout, worth
from benchmarks.harness import Row, aligned, main, must_show, peak_mib
from benchmarks.recognition_rows import (
    SHARES,
    averages,
    by_object,
    decision_time,
    errors,
    estimates,
    held_back,
    in_all,
)
from benchmarks.truth import objects
from hannes import Experiment, Hand, Reference, Target, simulate_many
from hannes.core.errors import ComputationFailed
from hannes.dataset.make import make
from hannes.dataset.spec import Spec, load_spec, read_spec
from hannes.recognition import model_file
from hannes.recognition.evaluate import CLASSES, Subject, evaluate, learning_curve
from hannes.recognition.train import TREES, curve, train

OUT = Path("results/recognition")
GRASPS, SEED = 12, 2026  # of each object
STRANGERS, FEWER, OTHER = 90, 4, 4052  # objects drawn at random, grasps of each, seed
SETS = ("eighteen", "large", "seated")
SECONDS, MEMORY = 60.0, 1024.0  # of work for 10,000 grasps; MiB
REPEATS = 500  # bootstrap
HOLDS = (90.0, 98.0)  # %, of 95 % intervals
DRIFT = 2.0  # %, of a held grasp's force in ten seconds


def subjects(quick: bool) -> list[Subject]:
    """The ten objects, each grasped by hands of its own."""
    count = 3 if quick else GRASPS
    made = objects.make(count, SEED)
    return [
        Subject(
            each.name,
            CLASSES.index(each.label),
            tuple(made[f"{each.stem}-{n + 1:02d}"] for n in range(count)),
            each.values["stiffness"],
        )
        for each in objects.things()
    ]


def strangers(quick: bool) -> list[Subject]:
    """Objects drawn at random: ten, of which three are prisms, say little about an interval."""
    found = []
    for k, each in enumerate(objects.strangers(9 if quick else STRANGERS, OTHER)):
        try:
            made = tuple(objects.grasp(each, (OTHER, k, n)) for n in range(FEWER))
        except ComputationFailed:  # no hand holds it
            continue
        stiffness = each.values["stiffness"]
        found.append(Subject(each.name, CLASSES.index(each.label), made, stiffness))
    return found


def spread(model: Any, chosen: Sequence[Subject]) -> dict[str, dict[str, float]]:
    """Intervals of the averages, by resampling each object's grasps."""
    evaluated = [evaluate(model, [Subject(s.name, s.label, (r,))])["objects"][0]
            for s in chosen for r in s.recordings]  # fmt: skip
    sizes = [len(s.recordings) for s in chosen]
    starts = np.cumsum([0, *sizes[:-1]])
    right = np.array([row["answers"][row["class"]] for row in evaluated])
    windows = np.array([row["windows"] for row in evaluated], float)
    stable = np.array([row["stable_in_time"] for row in evaluated])
    whole = np.array([row["f1_grasps"] for row in evaluated])
    rng, found = np.random.default_rng(0), []
    for _ in range(REPEATS):
        picks = [a + rng.integers(0, n, n) for a, n in zip(starts, sizes, strict=True)]
        shares = [np.average(right[p], weights=windows[p]) for p in picks]
        grasps = [whole[p].mean() for p in picks]
        f1 = [[2 * r / (r + 1) for r in each] for each in (shares, grasps)]
        in_time = np.mean([stable[p].mean() for p in picks])
        found.append((np.mean(f1[0]), np.mean(f1[1]), min(f1[0]), in_time))
    low, high = np.percentile(found, (2.5, 97.5), axis=0)
    return {n: {"low": 100 * float(a), "high": 100 * float(b)}
            for n, a, b in zip(SHARES, low, high, strict=True)}  # fmt: skip


def build(name: str, share: float = 1.0) -> dict[str, Any]:
    """Simulate a shipped data set anew in a process of its own; what it took."""
    path = OUT / f"{name}{'' if share == 1.0 else '-part'}.h5"
    path.unlink(missing_ok=True)
    call = f"from benchmarks.recognition import built; built({name!r}, {share})"
    done = subprocess.run(
        [sys.executable, "-c", call], stdout=subprocess.PIPE, text=True, check=True
    )
    return json.loads(done.stdout)


def built(name: str, share: float = 1.0) -> None:
    """Make a data set, or a share of its grasps, and print what it took.

    Seconds by the clock and of all processors; memory of this process and of its largest worker.
    """
    import resource

    from joblib.externals.loky import get_reusable_executor

    spec = load_spec(name) if share == 1.0 else part_of(name, share)
    spec.hand.compiled(spec.hand.effects)

    def spent() -> float:
        return sum(
            sum(resource.getrusage(who)[:2])
            for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        )

    before, start = spent(), time.perf_counter()
    make(spec, OUT / f"{name}{'' if share == 1.0 else '-part'}.h5")
    clock = time.perf_counter() - start
    get_reusable_executor().shutdown(wait=True)  # the time of workers counts once they have ended
    cost = {"clock_s": clock, "processor_s": spent() - before, "peak_MiB": peak_mib()}
    cost["worker_MiB"] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(json.dumps(cost))


def part_of(name: str, share: float) -> Spec:
    """A shipped data set with a share of the grasps of each of its groups."""
    spec = load_spec(name)
    text = re.sub(r"^draws = (\d+)$", lambda found: f"draws = {round(share * int(found[1]))}",
                  spec.text, flags=re.MULTILINE)  # fmt: skip
    return read_spec(text, name)


def scores(
    name: str, quick: bool, chosen: Sequence[Subject], others: Sequence[Subject]
) -> tuple[list[Row], dict[str, Any]]:
    """Train on a data set and score; rows by object."""
    model, known = train(
        OUT / f"{name}.h5", trees=80 if quick else TREES, most=1000 if quick else None
    )
    model_file.write(OUT / f"{name}-model.h5", model)
    evaluated, drawn = evaluate(model, chosen), evaluate(model, others)
    ends = spread(model, chosen)
    rows = [*by_object(name, evaluated), *in_all(name, evaluated, ends)]
    for key, words in (("force", "peak force"), ("stiffness", "stiffness")):
        rows += [estimates(f"{name}: {words}", evaluated[key])]
        rows += [estimates(f"{name}: {words}, objects drawn", drawn[key])]
    if "test_scores" in known:
        rows.append(held_back(name, known["test_scores"]))
    rows.append(decision_time(name, model, chosen[0].recordings[0]))
    return rows, {**evaluated, "interval": ends, "drawn": drawn}


def learning(quick: bool, chosen: Sequence[Subject]) -> list[Row]:
    """The large data set's learning curve."""
    rows = learning_curve(curve(OUT / "large.h5", trees=40 if quick else TREES // 2), chosen)
    return [
        {
            "what": f"large: learnt from {row['grasps']} grasps",
            "F1_windows_%": 100 * row["f1_windows"],
            "F1_grasps_%": 100 * row["f1_grasps"],
            "stable_in_150_ms_%": 100 * row["stable_in_time"],
        }
        for row in rows
    ]


def held() -> Row:
    """How far the forces of grasps held for ten seconds drift with the stiction law."""
    hand = Hand(["stiction"]).with_values({"stiction.share": 1.0})
    close = Reference([[0.0, 0.5], [0.0, 7.7]])
    hold = Experiment("held", 11.0, close, Target("cylinder"), sampling=100.0)
    stiffness = {"object.stiffness": [800.0, 5000.0, 38300.0]}
    runs = simulate_many(hand, hold, stiffness, channels=("force",), workers=1, progress=False)
    forces = np.array([each.require()["force"][100:] for each in runs])
    drift = float(100.0 * (np.ptp(forces, axis=1) / forces[:, 0]).max())
    name = "force of a grasp held for ten seconds, worst drift, %"
    return must_show(name, drift, DRIFT, drift <= DRIFT)


def bounds(large: dict[str, Any], small: dict[str, Any], cost: dict[str, Any]) -> list[Row]:
    """What must hold of the large data set's model; the small one's beside it."""
    force, ends = large["force"], large["interval"]

    def above(name: str, value: float, bound: float, **more: float) -> Row:
        return must_show(name, value, bound, value >= bound) | more

    error, drawn = force["median_error_percent"], large["drawn"]["force"]
    taken = cost["peak_MiB"] + os.cpu_count() * cost["worker_MiB"]
    return [
        above("F1 per window, average, %", 100 * large["f1_windows"], 95, **ends["f1_windows"]),
        above("F1 per grasp, average, %", 100 * large["f1_grasps"], 98, **ends["f1_grasps"]),
        above("F1 per window, worst object, %", 100 * large["f1_worst"], 85, **ends["f1_worst"]),
        above("F1 per window, average, % (paper's design, no bound)", 100 * small["f1_windows"], 0,
              **small["interval"]["f1_windows"]),
        above("grasps decided for good within 150 ms, %", 100 * large["stable_in_time"], 95,
              **ends["stable_in_time"]),
        above("F1 per window from contact on, %", 100 * large["from_contact"]["f1_windows"], 95),
        above("F1 per window from contact on, worst object, %",
              100 * large["from_contact"]["f1_worst"], 85),
        must_show("peak force, median error, %", error, 5, error <= 5) | errors(force),
        between("its 95 % interval holds", [force]),
        between("its 95 % interval holds, objects drawn", [drawn]),
        *(between(f"its 95 % interval holds{which}, where there is one", found, "answered")
          for which, found in ((", objects drawn", [drawn]), (", both", [force, drawn]))),
        must_show("10,000 grasps, processor seconds over two cores", cost["processor_s"] / 2,
                  SECONDS, cost["processor_s"] / 2 <= SECONDS),
        must_show("memory of it and its workers, MiB", taken, MEMORY, taken < MEMORY),
    ]  # fmt: skip


def between(name: str, found: Sequence[dict[str, Any]], of: str = "grasps") -> Row:
    """Coverage within its limits: over all grasps, or over those with an estimate."""
    held = sum(each["interval_holds"] * each["grasps"] for each in found)
    count = sum(each[of] for each in found)
    share = 100 * held / count
    least, most = HOLDS
    ok = least <= share <= most
    return must_show(f"{name}, of {count} grasps, % (at most {most:g})", share, least, ok)


def recognised(quick: bool) -> tuple[list[Row], list[Row]]:
    """Make all data sets, train on each, score all on the same recordings."""
    build("large", 0.01)  # compiles: what that takes once is in `start`, not here
    costs = {name: build(name) for name in SETS}
    chosen = subjects(quick)
    rows: list[Row] = [{"what": f"{name}: made", **cost} for name, cost in costs.items()]
    rows.append({"what": "large: a tenth of it made", **build("large", 0.1)})
    evaluated, others = {}, strangers(quick)
    for name in SETS:
        found, evaluated[name] = scores(name, quick, chosen, others)
        rows += found
    rows += learning(quick, chosen)
    return rows, bounds(evaluated["large"], evaluated["eighteen"], costs["large"])


def again(quick: bool) -> tuple[list[Row], list[Row]]:
    """The same data sets learnt from with other seeds: what one training differs by from others."""
    rows, chosen = [], subjects(quick)
    for name in ("large", "seated"):
        if not (OUT / f"{name}.h5").exists():
            build(name)
        for seed in (1,) if quick else (1, 2):
            model, _ = train(OUT / f"{name}.h5", trees=80 if quick else TREES, seed=seed)
            evaluated = evaluate(model, chosen)
            force = evaluated["force"]
            rows.append({"what": f"{name}: seed {seed}",
                         **averages({key: 100 * evaluated[key] for key in SHARES}),
                         "off_%": force["median_error_percent"],
                         "interval_holds_%": 100 * force["interval_holds"],
                         "sure_from_%": 100 * model.sure})  # fmt: skip
    return rows, []


def damaged(quick: bool) -> tuple[list[Row], list[Row]]:
    """Damage the paper's design, and a model that has all parts: a hundred grasps are enough."""
    build("eighteen")
    build("large", 0.01)
    model_file.write(OUT / "part-model.h5", train(OUT / "large-part.h5", trees=40)[0])
    return fuzzed.measure(quick, OUT / "part-model.h5", OUT / "eighteen.h5")


PARTS = {
    "scores": recognised,
    "again": again,
    "held": lambda quick: ([], [held()]),
    "rollout": rollout.measure,
    "damaged": damaged,
    "worth": worth.measure,
    "killed": killed.measure,
}


def measure(quick: bool, only: Sequence[str]) -> tuple[list[Row], list[Row]]:
    """One part after the other."""
    OUT.mkdir(parents=True, exist_ok=True)
    found = [PARTS[part](quick) for part in PARTS if part in only]
    return aligned([row for rows, _ in found for row in rows]), [
        row for _, must in found for row in must
    ]


if __name__ == "__main__":
    main(__doc__, "recognition", measure, tuple(PARTS))
