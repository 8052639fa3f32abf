"""Batches: grasps per second and over cores, memory of a long stream, what controller, effects and
an object that floats cost.

Dynamometer grasps, each with another object, motor friction and moment arm, through
`simulate_many`. Cores are compared by wall clock, all else by processor time of one worker; what
is compared runs in turn, repeated. Intervals are 95 % (bootstrap over repeats). The error is the
worst over the trace of the shipped hand, relative to its peak, against Radau at rtol 1e-9.
"""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from tqdm import tqdm

from benchmarks.accuracy_work import TRACES, errors
from benchmarks.harness import Row, aligned, interval, main, must_show, peak_mib
from hannes import Hand, effects, load_experiment, simulate, simulate_many
from hannes.core.effect import Effect
from hannes.simulation.experiment.experiment import CONTROLLERS, Experiment
from hannes.simulation.hand.model import EQUATIONS

# Tolerance and sampling [Hz] of what is asked for.
SETTINGS = ((1e-2, 100.0), (1e-2, 1000.0), (1e-3, 1000.0), (1e-4, 1000.0))
CHANNELS = ("current", "force")
SMALL = 1e-3  # of an amplitude's range: small enough to leave the motion as it is
NOTICEABLE = 1e-2  # of the same: a torque's ripple is followed turn by turn
STREAMED = 100_000, 2_000  # grasps, whole and quick
RIPPLE = "torque_ripple"
LEFT_OUT = "all effects left out, at off"
FLOATING = "floating_object"
Case = tuple[Any, ...]


def grasp() -> Experiment:
    """The dynamometer grasp."""
    return load_experiment("dynamometer")[0].experiment


def columns(count: int) -> dict[str, np.ndarray]:
    """Values of `count` grasps, the same ones every time."""
    rng, shipped = np.random.default_rng(1), Hand().parameters
    ranges = {"motor.dry_friction": 0.2, "mcp.moment_arm": 0.05}
    stiffness = np.exp(rng.uniform(np.log(1e3), np.log(5e4), count))
    return {"object.stiffness": stiffness} | {
        name: shipped[name] * rng.uniform(1.0 - part, 1.0 + part, count)
        for name, part in ranges.items()
    }


def ran(count: int, hand: Hand | None = None, experiment: Experiment | None = None, **how: Any):
    """Run a batch to its end."""
    given = (hand or Hand(), experiment or grasp(), columns(count))
    for found in simulate_many(*given, channels=CHANNELS, **how):
        found.require()


@dataclass(frozen=True)
class Spent:
    """Seconds of each repeat, by the clock and of the processor, shape (repeats,)."""

    clock: np.ndarray
    processor: np.ndarray


def timed(cases: Mapping[Case, Callable[[], None]], repeats: int) -> dict[Case, Spent]:
    """Time all cases in turn, repeated; once before, to compile."""
    spent: dict[Case, list[tuple[float, float]]] = {case: [] for case in cases}
    for repeat in tqdm(range(repeats + 1), "batches", leave=False):
        for case, run in cases.items():
            start = time.perf_counter(), time.process_time()
            run()
            if repeat > 0:
                end = time.perf_counter(), time.process_time()
                spent[case].append((end[0] - start[0], end[1] - start[1]))
    return {case: Spent(*np.array(seconds).T) for case, seconds in spent.items()}


def ratio(over: np.ndarray, under: np.ndarray) -> Row:
    """Median of the ratios of what ran in turn, with its interval."""
    return {"value": float(np.median(over / under)), **interval(over / under)}


def row(what: str, count: int, seconds: np.ndarray, **more: Any) -> Row:
    """A line of the table; the spread is the range over repeats."""
    middle = float(np.median(seconds))
    return {
        "what": what,
        "grasps_per_s": count / middle,
        "ms_per_grasp": 1e3 * middle / count,
        "spread_%": 100.0 * float(np.ptp(seconds)) / middle,
        **more,
    }


def throughput(quick: bool) -> tuple[list[Row], list[Row]]:
    """Grasps per second on one core and on two, by the clock; and how many cores were to be had."""
    count, repeats = (400, 3) if quick else (2000, 21)
    exact = simulate(Hand(), grasp(), method="Radau", rtol=1e-9).require()
    cases = {
        (*setting, cores): partial(ran, count, rtol=setting[0], sampling=setting[1], workers=cores)
        for setting in SETTINGS
        for cores in (1, 2)
    }
    spent = timed(cases, repeats)
    rows = []
    for (rtol, sampling, cores), took in spent.items():
        off = errors(simulate(Hand(), grasp(), rtol=rtol), exact)
        what = f"rtol {rtol:g}, {sampling:g} samples/s, {cores} core{'s' * (cores > 1)}"
        more = {
            "cores_used": float(np.median(took.processor / took.clock)),
            "worst_error_%": max(off[f"{name}_worst_%"] for name in TRACES),
        }
        rows.append(row(what, count, took.clock, **more))
    gains = [ratio(spent[*s, 1].clock, spent[*s, 2].clock) for s in SETTINGS]
    least = min(gains, key=lambda gain: gain["value"])
    used = min(each["cores_used"] for each in rows[1::2])
    name = f"two cores over one, least of all settings ({used:.2f} cores to be had)"
    many = rows[1]["grasps_per_s"]
    quickest = min(spent[*s, 1].clock.min() / spent[*s, 2].clock.min() for s in SETTINGS)
    summary = {
        "what": "two cores over one by the quickest turn of each, the least",
        "value": quickest,
    }
    return [*rows, summary], [
        must_show(name, 0.0, 1.8, least["value"] >= 1.8) | least,
        must_show(f"stretch: grasps/s, {rows[1]['what']}", many, 5000, many >= 5000),
    ]


def controllers(quick: bool) -> tuple[list[Row], list[Row]]:
    """The continuous controller beside the sampled one."""
    count, repeats = (60, 3) if quick else (200, 9)
    cases = {
        (kind,): partial(
            ran, count, experiment=replace(grasp(), controller=kind), rtol=1e-3, workers=1
        )
        for kind in CONTROLLERS
    }
    spent = timed(cases, repeats)
    return [
        row(f"{kind} controller, rtol 0.001", count, took.processor)
        for (kind,), took in spent.items()
    ], []


def objects(quick: bool) -> tuple[list[Row], list[Row]]:
    """Objects fixed to the bench beside the same ones floating between fingers and palm."""
    count, repeats = (60, 5) if quick else (200, 15)
    hands = {"fixed": Hand(), "floating": Hand([FLOATING]).with_values({f"{FLOATING}.free": 1.0})}
    grasps = {"cylinders": grasp(), "balls": load_experiment("soft-ball")[0].experiment}
    cases = {
        (what, how): partial(ran, count, hand, experiment, rtol=1e-4, workers=1)
        for what, experiment in grasps.items()
        for how, hand in hands.items()
    }
    spent = timed(cases, repeats)
    rows = []
    for (what, how), took in spent.items():
        times = float(np.median(took.processor / spent[what, "fixed"].processor))
        rows.append(row(f"{how} {what}, rtol 0.0001", count, took.processor, over_fixed=times))
    return rows, []


def with_effects(chosen: tuple[Effect, ...], share: float) -> Hand:
    """A hand with effects at a share of the range of each amplitude, away from off."""
    sizes = {
        effect.full_name(each.name): each.off + share * (each.bounds[1] - each.off)
        for effect in chosen
        for each in effect.amplitudes
        if each.off is not None
    }
    return Hand(chosen).with_values(sizes)


def effect_costs(quick: bool) -> tuple[list[Row], list[Row]]:
    """Cost against the number of effects in the model, present or left out.

    The evaluations of one grasp show how much of the cost is finer motion. Absent effects are no
    part of the machine code and cost nothing, so their ratio shows the noise of the others.
    """
    count, repeats = (60, 5) if quick else (200, 15)
    known = tuple(each for each in effects().values() if not EQUATIONS.accepts(each))
    most = len(known)
    numbers = (0, most) if quick else sorted({0, 1, most // 2, most})
    hands = {f"{n} effects present": with_effects(known[:n], SMALL) for n in numbers}
    smooth = tuple(each for each in known if each.name != RIPPLE)
    hands[f"{most} effects present, ten times as large"] = with_effects(known, NOTICEABLE)
    hands[f"all effects but {RIPPLE}, ten times as large"] = with_effects(smooth, NOTICEABLE)
    hands[LEFT_OUT] = with_effects(known, 0.0)
    spent = timed(
        {(what,): partial(ran, count, hand, rtol=1e-3, workers=1) for what, hand in hands.items()},
        repeats,
    )
    rows = [
        row(
            *(what, count, spent[what,].processor),
            evaluations=simulate(hand, grasp(), rtol=1e-3).cost.evaluations,
            jacobian=hand.compiled().jacobian_kind,
        )
        for what, hand in hands.items()
    ]
    base = spent["0 effects present",].processor
    present = ratio(spent[f"{most} effects present",].processor, base)
    absent = ratio(spent[LEFT_OUT,].processor, base)
    same = hands[LEFT_OUT].compiled() is Hand().compiled()
    name = f"machine code of {most} effects left out is that of none (1: yes)"
    rows.append({"what": "effects left out over none, time", **absent})
    larger = ratio(spent[f"{most} effects present, ten times as large",].processor, base)
    return rows, [
        must_show(f"{most} effects present over none", 0.0, 1.5, present["value"] <= 1.5) | present,
        must_show("the same, ten times as large", 0.0, 1.5, larger["value"] <= 1.5) | larger,
        must_show(name, float(same), 1.0, same),
    ]


def stream(count: int) -> None:
    """Stream a batch and print what it took, for a process of its own."""
    start = time.perf_counter()
    ran(count, rtol=1e-2)
    print(json.dumps({"seconds": time.perf_counter() - start, "peak_MiB": peak_mib()}))


def memory(quick: bool) -> tuple[list[Row], list[Row]]:
    """Peak resident memory of a long stream in a fresh process."""
    count = STREAMED[quick]
    call = f"from benchmarks.batch import stream; stream({count})"
    done = subprocess.run(
        [sys.executable, "-c", call], stdout=subprocess.PIPE, text=True, check=True
    )
    found = json.loads(done.stdout)
    what = f"{count} grasps streamed, rtol 0.01, 1000 samples/s"
    line = row(what, count, np.array([found["seconds"]]), peak_MiB=found["peak_MiB"])
    peak = found["peak_MiB"]
    return [line], [must_show(f"{count} grasps streamed: peak MiB", peak, 300, peak < 300)]


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Run all parts."""
    rows, bounds = [], []
    for part in (throughput, controllers, objects, effect_costs, memory):
        found, asked = part(quick)
        rows += found
        bounds += asked
    return aligned(rows), bounds


if __name__ == "__main__":
    main(__doc__, "batch", measure)
