"""Covariance of empty campaigns as far as it is linear in what scatters.

    T = J P J' + sum over conditions of (R_c + N_c) / repeats

J: slopes of all that hands scatter; R_c: of what runs scatter, in one condition; N: sensor noise.
What is not linear follows from the empty campaigns themselves (see `discriminant`).
"""

import numpy as np

from benchmarks.oracle.bench import Bench
from benchmarks.oracle.features import BINS
from benchmarks.truth.campaign import Spread
from benchmarks.truth.parameters import FINGERS, GEOMETRY, NOMINAL, OWN, flat
from benchmarks.truth.scatter import EXACT, PLACES, RUN_PLACES, RUN_TO_RUN

Column = tuple[np.ndarray, float]  # slope, and standard deviation of what moves along it


def expected(bench: Bench, spread: Spread) -> np.ndarray:
    """The covariance T of a protocol's vectors, (n, n)."""
    hands = np.array([derivative * deviation for derivative, deviation in of_hands(bench, spread)])
    runs = np.array([derivative * deviation for derivative, deviation in of_runs(bench, spread)])
    repeats = [each.repeats for each in bench.whole.conditions]
    each = np.repeat(repeats, bench.blocks)
    same = np.repeat(np.arange(len(repeats)), bench.blocks)
    within = (runs.T @ runs) * (same[:, None] == same)
    return hands.T @ hands + within / each + np.diag(noise(bench) / each)


def noise(bench: Bench) -> np.ndarray:
    """Variance from sensors, smoothed: a bin whose sensor happened to stand still has noise too."""
    variance = bench.noise().reshape(-1, BINS)
    return np.repeat(variance.mean(axis=1), BINS)


def of_hands(bench: Bench, spread: Spread) -> list[Column]:
    """What differs between hands, and between an object and what the bench believes of it."""
    names = [name for name, value in flat(NOMINAL).items() if _scatters(name, value)]
    own = [
        (f"object.{key}", each)
        for each in bench.once.conditions
        for key in (each.thing or {})
        if len(each.thing or {}) > 1 and key != "shape"
        if _scatters(f"object.{key}", each.thing[key])
    ]
    columns = [(bench.derivative(name), _hand(name, spread)) for name in names]
    columns += [(bench.derivative(name, each), _hand(name, spread)) for name, each in own]
    return columns + (of_joints(bench, spread) if spread.finger else [])


def of_joints(bench: Bench, spread: Spread) -> list[Column]:
    """What each joint has for itself, as a factor."""
    names = [f"{finger}.{own.partition('.')[2]}" for finger in FINGERS for own in OWN]
    return [(bench.derivative(name), spread.finger) for name in names]


def of_runs(bench: Bench, spread: Spread) -> list[Column]:
    """What differs between runs."""
    columns = [(bench.start_offset(), spread.timing)]
    for name in NOMINAL:
        share = RUN_PLACES.get(name) or RUN_TO_RUN.get(name.partition(".")[2], 0.0)
        if share:
            columns.append((bench.derivative(name), spread.run * share))
            columns += [
                (bench.derivative(name, each), spread.run * share)
                for each in bench.once.conditions
                if name.partition(".")[2] in (each.thing or {})
            ]
    return columns


def _scatters(name: str, value: float) -> bool:
    """Whether hands differ in it; a finger's value goes by the name that all five share."""
    finger, _, what = name.partition(".")
    shared = GEOMETRY[what] if finger in FINGERS else name
    return name in PLACES or (value != 0.0 and not shared.startswith(EXACT))


def _hand(name: str, spread: Spread) -> float:
    return spread.hand * PLACES.get(name, 1.0)
