"""The pool of sound machines: few runs by the independent truths, logged anew for each case.

A run is had once, without a logger's noise; a logger then samples, adds noise, and rounds.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.intake.log import Log
from benchmarks.truth import bench, servo
from benchmarks.truth.parameters import parse_hand
from benchmarks.truth.protocol import DYNAMOMETER, PAPER, SOFT_BALL, Condition, scaled
from benchmarks.truth.record import posed
from benchmarks.truth.scatter import run_scatter, scatter
from benchmarks.truth.simulation import trace

FloatArray = NDArray[np.float64]

MACHINES = ("hand", "axis", "servo")
HANDS, DRIVEN = 3, 12  # different machines in the pool, of the hand and of each of the others
# Of a machine's values, and of a run's (see truth.scatter): the library's default of `run_scatter`.
SPREAD, RUN = 0.02, 0.01
REPEATS = 4  # runs under the same command, that say how much they scatter
START = 10e-3  # s, its default of `start_time`: what a floor has of it
CONDITIONS = (
    Condition("void", PAPER, 2),
    Condition("half speed", scaled(PAPER, 0.5), 2),
    Condition("slow", scaled(PAPER, 0.2), 2),
    Condition("dynamometer", PAPER, 2, DYNAMOMETER, sensor=True),
    Condition("dynamometer, 0.4 speed", scaled(PAPER, 0.4), 2, DYNAMOMETER, sensor=True),
    Condition("soft ball", PAPER, 2, SOFT_BALL),
)
# Standard deviation of noise, and step, of each channel.
SENSORS: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "hand": {
        "position": (0.0, 2 * np.pi / 4096),
        "current": (bench.CURRENT, bench.CURRENT_STEP),
        "duty": (0.0, 1e-3),
        "supply": (bench.SUPPLY, bench.SUPPLY_STEP),
        "force": (bench.FORCE, bench.FORCE_STEP),
        "sensor": (bench.FORCE, bench.FORCE_STEP),
    },
    "axis": {"position": (0.0, 2e-7), "drive": (5e-3, 1e-3)},
    "servo": {"position": (0.0, 2 * np.pi / 16384), "current": (5e-3, 2e-3)},
}


@dataclass(frozen=True)
class Base:
    """One run of one machine at 1 kHz, as it is: channels by name, (n,); noise_floors by channel.

    experiment: what was done, where it is known by name; noise_floors: RMS by which repeats differ;
    values: of the driven machine, by names of `truth.servo`, none of the hand; repeats: channels of
    further runs under the same command.
    """

    machine: str
    number: int
    channels: Mapping[str, FloatArray]
    noise_floors: Mapping[str, float]
    experiment: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    repeats: tuple[Mapping[str, FloatArray], ...] = ()


@dataclass(frozen=True)
class Logger:
    """How a run is logged: rate [Hz], noise and steps by factors, jitter as a share of a period."""

    rate: float = 1000.0
    noise: float = 1.0
    step: float = 1.0
    jitter: float = 0.0
    bits: int = 0


def count(machine: str) -> int:
    """How many runs the pool has of a machine."""
    return HANDS * len(CONDITIONS) if machine == "hand" else DRIVEN


@cache
def base(machine: str, number: int) -> Base:
    """One run of the pool, `number` from 0."""
    runs = [_run(machine, number, repeat) for repeat in range(REPEATS)]
    noise_floors = {}
    for name, values in runs[0].items():
        if name not in ("time", "reference"):
            noise, step = SENSORS[machine][name]
            scatter = float(np.mean(np.var([each[name] for each in runs], axis=0, ddof=1)))
            moved = START * np.gradient(values, 1e-3) if name == "position" else np.zeros(1)
            scatter += float(np.mean(moved**2))
            noise_floors[name] = float(np.sqrt(scatter + noise**2 + step**2 / 12.0))
    text = bench.experiment_text(_condition(number)) if machine == "hand" else ""
    drawn = {} if machine == "hand" else _values(machine, number, 0)
    return Base(machine, number, runs[0], noise_floors, text, drawn, tuple(runs[1:]))


def other(machine: str, number: int) -> Base:
    """Another run of the same machine, under another command."""
    return base(machine, (number + 1) % count(machine))


def _condition(number: int) -> Condition:
    return CONDITIONS[number % len(CONDITIONS)]


def _run(machine: str, number: int, repeat: int) -> dict[str, FloatArray]:
    if machine == "hand":
        return _hand_run(number // len(CONDITIONS), _condition(number), repeat)
    return _driven_run(machine, number, repeat)


def _hand_run(hand: int, condition: Condition, repeat: int) -> dict[str, FloatArray]:
    values = scatter(parse_hand('base = "hannes"\n'), np.random.default_rng(hand), SPREAD)
    thing = condition.thing
    rng = np.random.default_rng([hand, repeat])
    run, shift = run_scatter(posed(values, thing), rng, RUN, 0.2e-3)
    shape = {"shape": thing["shape"]} if thing else None
    found, _ = trace(run, condition.points, shape, condition.duration, shift=shift)
    names = {each: each.rpartition("_")[0] for each in found}
    forces = () if condition.sensor else ("force", "sensor")
    return {short: found[name] for name, short in names.items() if short not in forces}


def _values(machine: str, number: int, repeat: int) -> dict[str, float]:
    """Values of one axis or servo in one of its runs."""
    shipped = servo.AXIS if machine == "axis" else servo.SERVO
    kept = ("kp", "kd", "limit", "period", "encoder", "width", "offset")
    values = dict(shipped)
    for seed, spread in ((np.random.default_rng(number), 0.1),
                         (np.random.default_rng([number, repeat, 1]), RUN)):  # fmt: skip
        for name in values:
            factor = 1.0 + spread * float(seed.standard_normal())
            values[name] *= 1.0 if name in kept else factor
    return values


def _driven_run(machine: str, number: int, repeat: int) -> dict[str, FloatArray]:
    return driven(machine, _values(machine, number, repeat), _asked(machine, number))


def driven(machine: str, values: Mapping[str, float], asked: FloatArray) -> dict[str, FloatArray]:
    """Channels of an axis or a servo under a command at 1 kHz, (n,)."""
    found = servo.simulate(values, asked)
    names = {"drive": "current"} if machine == "servo" else {}
    return {names.get(name, name): x for name, x in found.items() if name != "speed"}


def _asked(machine: str, number: int) -> FloatArray:
    """A command of some seconds: smooth strokes there and back, or a servo's steps and sines."""
    rng = np.random.default_rng([number, 7])
    time = np.arange(round(1000 * rng.uniform(2.5, 5.0))) / 1000.0
    size, pace = (0.06, 1.5) if machine == "axis" else (1.2, 1.0)
    marks = np.concatenate(([0.0, 0.25], 0.25 + pace * np.cumsum(rng.uniform(0.3, 0.9, 12))))
    goals = np.concatenate(([0.0, 0.0], size * rng.uniform(-1.0, 1.0, 12)))
    place = np.clip(np.searchsorted(marks, time, side="right") - 1, 0, marks.size - 2)
    share = np.clip((time - marks[place]) / (marks[place + 1] - marks[place]), 0.0, 1.0)
    style = number % 3 if machine == "servo" else 0
    if style == 1:  # steps, slewed
        share = np.clip(5.0 * share, 0.0, 1.0)
    smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2) if style != 1 else share
    asked = goals[place] + (goals[place + 1] - goals[place]) * smooth
    if style == 2:
        since = np.maximum(time - 0.25, 0.0)
        asked = 0.6 * size * np.sin(2 * np.pi * rng.uniform(0.4, 1.5) * since)
    return asked


def logged(run: Base, logger: Logger, referenced: bool, rng: np.random.Generator) -> Log:
    """What a sound logger writes of a run."""
    another = other(run.machine, run.number)
    asked = run.channels["reference"], another.channels["reference"]
    return Log(
        run.machine,
        _columns(run, logger, referenced, rng),
        _columns(another, logger, referenced, rng),
        np.array_equal(asked[0], asked[1]),
    )


def _columns(
    run: Base, logger: Logger, referenced: bool, rng: np.random.Generator
) -> dict[str, FloatArray]:
    time = run.channels["time"]
    stamps = np.arange(int(time[-1] * logger.rate) + 1) / logger.rate
    late = logger.jitter / logger.rate * rng.uniform(-1.0, 1.0, stamps.size)
    stamps = np.maximum(stamps + late, 0.0) if logger.jitter else stamps
    stamps = np.unique(np.round(stamps, 9))
    columns = {"time": stamps}
    for name, values in run.channels.items():
        if name == "time" or (name == "reference" and not referenced):
            continue
        exact = np.interp(stamps, time, values)
        columns[name] = exact if name == "reference" else _read(run, logger, name, exact, rng)
    return columns


def _read(
    run: Base, logger: Logger, name: str, exact: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """A sensor's reading of exact values."""
    noise, step = SENSORS[run.machine][name]
    noisy = exact + logger.noise * noise * rng.standard_normal(exact.size)
    step *= logger.step
    if logger.bits:
        step = 2.4 * float(np.abs(run.channels[name]).max()) / 2.0**logger.bits
    return np.round(noisy / step) * step
