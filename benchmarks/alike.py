"""Slopes: grasps by the steps of another one, in lanes of vector registers and one by one.

A dynamometer grasp and 96 near it, along eight parameters, through `run_alike` on one core; both
ways in turn, by processor time. Numbers that differ in a bit are counted. The ideal is that of a
step loop of which a share of 0.37 is packed already, four numbers wide (docs/explanation/speed.md).
"""

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np
from tqdm import tqdm

from benchmarks.batch import SMALL, grasp, with_effects
from benchmarks.harness import Row, aligned, interval, main, must_show
from hannes import Hand, effects
from hannes.simulation.batch import in_step, lanes
from hannes.simulation.batch.chunks import Asked, Part, Table
from hannes.simulation.compiler.lanes import machine
from hannes.simulation.hand.model import EQUATIONS

COUNT = 97
ALONG = (
    "motor.dry_friction", "mcp.moment_arm", "object.stiffness", "pip.spring_stiffness",
    "motor.torque_constant", "supply.voltage", "cart.mass", "gear.ratio",
)  # fmt: skip
CHANNELS = {"current, position": ("current", "position"), "current, force": ("current", "force")}
RTOLS = (1e-2, 1e-4)
PACKED = 0.37  # of the step loop's time, instructions that are four numbers wide
SHARE = 0.75  # of the ideal, wanted


def columns(hand: Hand) -> dict[str, np.ndarray]:
    """The grasp, then each of the others with one parameter a thousandth off or so."""
    posed = hand.with_values(grasp().overrides()).parameters
    rng, turn = np.random.default_rng(1), np.arange(COUNT) % len(ALONG)
    sizes = 1e-3 * rng.standard_normal(COUNT) * (np.arange(COUNT) > 0)
    return {name: posed[name] * (1.0 + sizes * (turn == k)) for k, name in enumerate(ALONG)}


def part(hand: Hand, rtol: float, channels: tuple[str, ...]) -> Part:
    """All in one compiled call."""
    table = Table.of(hand, replace(grasp(), controller="continuous"), columns(hand))
    return next(iter(table.alike(Asked(channels, None, rtol, None, 1), 1)))[0]


def ran(given: Part, width: int) -> tuple[np.ndarray, float]:
    """What was asked for, and processor time [s]."""
    with mock.patch.object(machine, "width", lambda: width):
        clock, stop = time.process_time(), np.zeros(1, np.bool_)
        made = in_step.run_alike(given.plan, given.vectors, given.starts.copy(), stop)
        return made.kept, time.process_time() - clock


def compared(given: Part, repeats: int) -> tuple[Row, np.ndarray]:
    """A row of both ways, and how many times as long one by one takes in each turn."""
    width, took = machine.width(), {1: list[float](), machine.width(): list[float]()}
    alone, together = (ran(given, way)[0] for way in (1, width))
    for _ in tqdm(range(repeats), "turns", leave=False):
        for way, seconds in took.items():
            seconds.append(ran(given, way)[1])
    times: Mapping[int, Any] = {way: np.array(each) for way, each in took.items()}
    row = {
        "lanes": width,
        "alone_ms_per_grasp": 1e3 * float(np.median(times[1])) / COUNT,
        "lanes_ms_per_grasp": 1e3 * float(np.median(times[width])) / COUNT,
        "differ": int(np.count_nonzero(alone != together)),
    }
    return row, times[1] / times[width]


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """The hand alone by tolerance and channels; whole also with the catalogue."""
    known = tuple(each for each in effects().values() if not EQUATIONS.accepts(each))
    hands = {"the hand": Hand()} | (
        {} if quick else {"with all effects": with_effects(known, SMALL)}
    )
    rows, bounds, ideal = [], [], machine.width() / (1.0 + 3.0 * PACKED)
    with mock.patch.object(lanes, "COMPILING", -1.0):
        for name, hand in hands.items():
            for rtol in RTOLS:
                for channels, asked in CHANNELS.items():
                    row, gain = compared(part(hand, rtol, asked), 5 if quick else 15)
                    what = f"{name}, {channels}, rtol {rtol:g}: one by one over lanes"
                    found = {"value": float(np.median(gain)), **interval(gain.tolist())}
                    held = found["value"] >= SHARE * ideal
                    bounds.append(must_show(what, 0.0, SHARE * ideal, held) | found)
                    rows.append({"what": f"{name}, {channels}, rtol {rtol:g}", **row})
    differing = sum(row["differ"] for row in rows)
    bounds.append(must_show("numbers that differ in a bit", differing, 0, differing == 0))
    return aligned(rows), bounds


if __name__ == "__main__":
    main(__doc__, "alike", measure)
