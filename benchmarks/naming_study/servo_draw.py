"""What is hidden in a servo case, drawn by its seed alone, and how large it must be to be seen.

Sizes are log-uniform between twice u and the end of a fixed range. u is the size that a test finds
in 80 % of campaigns at 5 % false alarms, which knows the effect, and knows of the machine and the
runs no more than their scatter: by the truth's own linearisation, not by the diagnosis.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from statistics import NormalDist

import numpy as np

from benchmarks.naming_study import servo_bench as bench
from benchmarks.truth import geared_servo as truth

# Effect by the plant's name -> the truth's names [SI], the end of the range, and its source.
RANGES: Mapping[str, tuple[str, float]] = {
    "command_delay": ("delay", 0.1),  # s: a bus with several servos, polled (a choice)
    "gear_load": ("load_share", 0.5),  # worm-like gears lose half (a choice)
    "stribeck": ("peak", 0.3),  # N m: twice the Coulomb level (Armstrong & Canudas de Wit 1995)
    "gear_backlash": ("gap", 0.05),  # rad: three degrees, a worn hobby gear
    "pwm_dead_band": ("swallowed", 0.1),  # duty (Jeong & Park 1991: some percent)
    "supply_sag": ("source", 1.5),  # ohm: two thin cells and leads
    "wrong_gravity": ("heavier", 0.4),  # N m: as much again
}
SHAPES = {"peak_speed": (0.05, 0.3)}  # rad/s, at the shaft
TIMES = 2.0  # u, at least


@dataclass(frozen=True)
class Hidden:
    """effects: by the plant's names; values: by the truth's names [SI]."""

    effects: tuple[str, ...]
    values: Mapping[str, float]


def drawn(what: str, seed: int) -> Hidden:
    """what: the name of an effect, "pair" or "sound"."""
    if what == "sound":
        return Hidden((), {})
    rng = np.random.default_rng([seed, bench.STREAM, 1])
    names = sorted(RANGES)
    effects = (what,) if what != "pair" else tuple(rng.choice(names, 2, replace=False).tolist())
    values: dict[str, float] = {}
    for effect in effects:
        name, most = RANGES[effect]
        values[name] = _log(rng, min(TIMES * smallest(effect), 0.99 * most), most)
        if effect == "stribeck":
            values["peak_speed"] = _log(rng, *SHAPES["peak_speed"])
        if effect == "wrong_gravity" and rng.random() < 0.5:  # turned as far as it would be heavier
            values = {**values, "tilted": values.pop(name) / truth.SERVO["weight"]}
    return Hidden(effects, values)


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(low * (high / low) ** rng.uniform())


@cache
def smallest(effect: str) -> float:
    """u of an effect [SI], at the middle of its shapes; its range's end where that is not seen."""
    name, most = RANGES[effect]
    size = 0.1 * most
    for _ in range(4):  # a secant of about its own size
        size = min(most, _size(name, size))
    return size


def _size(name: str, size: float) -> float:
    normal = NormalDist()
    wanted = normal.inv_cdf(0.95) + normal.inv_cdf(0.80)
    moved = (_vector({name: size}) - _vector({name: 1e-9 * size})) / size
    nuisances = np.array(_nuisances())
    left = np.linalg.solve(np.eye(len(nuisances)) + nuisances @ nuisances.T, nuisances @ moved)
    return float(wanted / np.sqrt(max(moved @ moved - (nuisances @ moved) @ left, 1e-30)))


def _vector(values: Mapping[str, float], start: float = 0.0) -> np.ndarray:
    """Mean of a command's runs, all commands, in standard deviations of its noise."""
    noise = {
        "position": np.hypot(bench.NOISE, bench.COUNT / np.sqrt(12.0)),
        "current": bench.AMPERES,
    }
    parts = []
    for command in bench.commands().values():
        run = bench.run(values, command, start)
        parts += [run[name] / each * np.sqrt(bench.RUNS) for name, each in noise.items()]
    return np.concatenate(parts)


@cache
def _nuisances() -> tuple[np.ndarray, ...]:
    """What a standard deviation of each value of the machine and of the runs does."""
    here, found = _vector({}), []
    runs = np.sqrt(bench.RUNS)
    for name, value in truth.SERVO.items():
        if name == "limit":
            continue
        step = bench.SCATTER * (1.0 if name == "angle" else value)
        moved = _vector({name: value + step}) - here
        found.append(moved)
        if name in ("dry", "viscous"):
            found.append(moved * bench.RUN_SCATTER / bench.SCATTER / runs)
    found.append((_vector({}, bench.START) - here) / runs)
    return tuple(found)
