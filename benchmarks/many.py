"""Batches: grasps by their own steps, in lanes of vector registers and one by one.

Dynamometer grasps as of `benchmarks.batch`, and a mixed batch in turn of nothing to hold, soft and
rigid objects, and hands that hardly move, through `run_many` on one core: 1,000 samples a second of
current and force; both ways in turn, by processor time. Numbers that differ in a bit are counted.
The ideal is that of `benchmarks.alike`.
"""

import time
from unittest import mock

import numpy as np
from tqdm import tqdm

from benchmarks.alike import PACKED
from benchmarks.batch import CHANNELS, SMALL, columns, grasp, with_effects
from benchmarks.harness import Row, aligned, interval, main, must_show
from hannes import Hand, effects
from hannes.simulation.batch import lanes
from hannes.simulation.batch.chunks import Asked, Part, Table
from hannes.simulation.batch.own_steps import run_many
from hannes.simulation.compiler.lanes import machine
from hannes.simulation.hand.model import EQUATIONS

COUNT = 128
SHARE, MIXED_SHARE = 0.6, 0.45  # of the ideal, wanted
SAMPLING, RTOLS = 1000.0, (1e-2, 1e-3, 1e-4)


def mixed(count: int) -> dict[str, np.ndarray]:
    """Values of grasps of four kinds, in turn."""
    turn, near = np.arange(count) % 4, np.linspace(1.0, 1.1, count)
    friction = Hand().parameters["motor.dry_friction"]
    return {
        "object.radius": np.where(turn == 0, 1e-4, 0.025) * near,
        "object.stiffness": np.where(turn == 1, 700.0, 4e4) * near,
        "motor.dry_friction": np.where(turn == 3, 15.0, 1.0) * friction * near,
    }


def cases(quick: bool) -> dict[str, tuple[Hand, dict[str, np.ndarray], float, float]]:
    """Hand, columns, tolerance and share of the ideal that is wanted, by what it is."""
    hand, found = Hand(), {}
    for rtol in RTOLS:
        found[f"dynamometer, rtol {rtol:g}"] = hand, columns(COUNT), rtol, SHARE
        found[f"mixed, rtol {rtol:g}"] = hand, mixed(COUNT), rtol, MIXED_SHARE
    if not quick:
        known = tuple(each for each in effects().values() if not EQUATIONS.accepts(each))
        rtol = 1e-3
        whole = with_effects(known, SMALL), columns(COUNT), rtol, SHARE
        found[f"dynamometer, the whole catalogue, rtol {rtol:g}"] = whole
    return found


def parts(hand: Hand, values: dict[str, np.ndarray], rtol: float) -> list[Part]:
    """Windows of a batch."""
    asked = Asked(CHANNELS, SAMPLING, rtol, hand.effects, 1)
    windows = Table.of(hand, grasp(), values).windows(asked)
    return [part for window in windows for part in window]


def ran(given: list[Part], width: int) -> tuple[np.ndarray, float]:
    """What was asked for, and processor time [s]."""
    stop = np.zeros(1, np.bool_)
    with mock.patch.object(machine, "width", lambda: width):
        clock = time.process_time()
        made = [run_many(each.plan, each.vectors, each.starts.copy(), stop) for each in given]
        seconds = time.process_time() - clock
    return np.concatenate([each.kept for each in made]), seconds


def compared(given: list[Part], repeats: int) -> tuple[Row, np.ndarray]:
    """A row of both ways, and how many times as long one by one takes in each turn."""
    width, took = machine.width(), []
    alone, together = (ran(given, way)[0] for way in (1, width))
    for _ in tqdm(range(repeats), "turns", leave=False):
        took.append([ran(given, way)[1] for way in (1, width)])
    seconds = np.array(took)
    row = {
        "lanes": width,
        "alone_ms_per_grasp": 1e3 * float(np.median(seconds[:, 0])) / COUNT,
        "lanes_ms_per_grasp": 1e3 * float(np.median(seconds[:, 1])) / COUNT,
        "differ": int(np.count_nonzero(alone != together)),
    }
    return row, seconds[:, 0] / seconds[:, 1]


def catalogue_over_hand(repeats: int = 9) -> Row:
    """Time with the whole catalogue over that of the hand alone, both in lanes, in turn."""
    known = tuple(each for each in effects().values() if not EQUATIONS.accepts(each))
    hands, width = (with_effects(known, SMALL), Hand()), machine.width()
    both = [parts(hand, columns(COUNT // 2), 1e-3) for hand in hands]
    times = np.array([[ran(each, width)[1] for each in both] for _ in range(repeats + 1)])[1:]
    found = times[:, 0] / times[:, 1]
    value = {"value": float(np.median(found)), **interval(found)}
    name = "the whole catalogue over the hand, in lanes, rtol 0.001"
    return must_show(name, 0.0, 1.5, value["value"] <= 1.5) | value


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """All cases; whole also with the catalogue."""
    rows, bounds, ideal = [], [], machine.width() / (1.0 + 3.0 * PACKED)
    with mock.patch.object(lanes, "COMPILING", -1.0):
        for what, (hand, values, rtol, share) in cases(quick).items():
            row, gain = compared(parts(hand, values, rtol), 7 if quick else 21)
            found = {"value": float(np.median(gain)), **interval(gain.tolist())}
            held = found["value"] >= share * ideal
            name = f"{what}: one by one over lanes"
            bounds.append(must_show(name, 0.0, share * ideal, held) | found)
            rows.append({"what": what, **row})
        if not quick:
            bounds.append(catalogue_over_hand())
    differing = sum(row["differ"] for row in rows)
    bounds.append(must_show("numbers that differ in a bit", differing, 0, differing == 0))
    return aligned(rows), bounds


if __name__ == "__main__":
    main(__doc__, "many", measure)
