"""Batches: grasps per second and over cores, memory of a long stream, what controller and effects
cost.

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
from dataclasses import replace
from typing import Any

import numpy as np
from tqdm import tqdm

from benchmarks.accuracy_work import TRACES, errors
from benchmarks.harness import Row, aligned, interval, main, must_show, peak_mib
from hannes import Hand, effects, load_experiment, simulate, simulate_many
from hannes.effect import Effect
from hannes.experiment import Experiment
from hannes.hand import EQUATIONS

# Tolerance and sampling [Hz] of what is asked for.
SETTINGS = ((1e-2, 100.0), (1e-2, 1000.0), (1e-3, 1000.0), (1e-4, 1000.0))
CHANNELS = ("current", "force")
SMALL = 0.01  # of an amplitude's range: small enough to leave the motion as it is
STREAMED = 100_000, 2_000  # grasps, whole and quick
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


def timed(
    cases: Mapping[Case, Callable[[], None]], clock: Callable[[], float], repeats: int
) -> dict[Case, np.ndarray]:
    """Seconds of each case, shape (repeats,), all cases in turn; once before, to compile."""
    spent: dict[Case, list[float]] = {case: [] for case in cases}
    for repeat in tqdm(range(repeats + 1), "batches", leave=False):
        for case, run in cases.items():
            start = clock()
            run()
            if repeat > 0:
                spent[case].append(clock() - start)
    return {case: np.array(seconds) for case, seconds in spent.items()}


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
    """Grasps per second on one core and on two."""
    count, repeats = (400, 3) if quick else (2000, 7)
    exact = simulate(Hand(), grasp(), method="Radau", rtol=1e-9).require()
    cases = {
        (*setting, cores): lambda s=setting, cores=cores: ran(
            count, rtol=s[0], sampling=s[1], workers=cores
        )
        for setting in SETTINGS
        for cores in (1, 2)
    }
    spent = timed(cases, time.perf_counter, repeats)
    rows = []
    for (rtol, sampling, cores), seconds in spent.items():
        off = errors(simulate(Hand(), grasp(), rtol=rtol), exact)
        worst = {"worst_error_%": max(off[f"{name}_worst_%"] for name in TRACES)}
        what = f"rtol {rtol:g}, {sampling:g} samples/s, {cores} core{'s' * (cores > 1)}"
        rows.append(row(what, count, seconds, **worst))
    fast = SETTINGS[0]
    gains = [ratio(spent[*setting, 1], spent[*setting, 2]) for setting in SETTINGS]
    least = min(gains, key=lambda gain: gain["value"])
    many = count / float(np.median(spent[*fast, 2]))
    return rows, [
        must_show("two cores over one, least of all settings", 0.0, 1.8, least["value"] >= 1.8)
        | least,
        must_show(f"stretch: grasps/s on two cores, {rows[1]['what']}", many, 5000, many >= 5000),
    ]


def controllers(quick: bool) -> tuple[list[Row], list[Row]]:
    """The continuous controller beside the sampled one."""
    count, repeats = (60, 3) if quick else (200, 9)
    kinds = ("continuous", "sampled")
    spent = timed(
        {
            (kind,): lambda kind=kind: ran(
                count, experiment=replace(grasp(), controller=kind), rtol=1e-3, workers=1
            )
            for kind in kinds
        },
        time.process_time,
        repeats,
    )
    return [row(f"{kind} controller, rtol 0.001", count, spent[kind,]) for kind in kinds], []


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
    """Cost against the number of effects in the model, present or left out."""
    count, repeats = (60, 5) if quick else (200, 15)
    known = tuple(each for each in effects().values() if not EQUATIONS.accepts(each))
    numbers = (0, len(known)) if quick else sorted({0, 1, len(known) // 2, len(known)})
    hands = {f"{n} effects present": with_effects(known[:n], SMALL) for n in numbers}
    hands["all effects left out, at off"] = with_effects(known, 0.0)
    spent = timed(
        {(what,): lambda hand=hand: ran(count, hand, rtol=1e-3, workers=1)
         for what, hand in hands.items()},
        time.process_time,
        repeats,
    )  # fmt: skip
    rows = [
        row(what, count, spent[what,], jacobian=hand.compiled().jacobian_kind)
        for what, hand in hands.items()
    ]
    base = spent["0 effects present",]
    present = ratio(spent[f"{len(known)} effects present",], base)
    absent = ratio(spent["all effects left out, at off",], base)
    same = hands["all effects left out, at off"].compiled() is Hand().compiled()
    return rows, [
        must_show(f"{len(known)} effects present over none", 0, 1.5, present["value"] <= 1.5)
        | present,
        must_show(f"{len(known)} effects left out over none (one machine code: {same})", 0, 1.05,
                  same and absent["value"] <= 1.05) | absent,
    ]  # fmt: skip


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
    return [line], [must_show(f"{count} grasps streamed: peak MiB", peak, 1024, peak < 1024)]


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Run all parts."""
    rows, bounds = [], []
    for part in (throughput, controllers, effect_costs, memory):
        found, asked = part(quick)
        rows += found
        bounds += asked
    return aligned(rows), bounds


if __name__ == "__main__":
    main(__doc__, "batch", measure)
