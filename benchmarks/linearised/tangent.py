"""What each parameter and each effect changes in a run of the truth, by differences about it.

    y(x) = y_0 + sum of (x - x_0) dy/dx + sum of a y_a(s)

y: position, current and forces at all samples of a condition; x: every value of the hand, those of
single joints included; a: amplitudes of effects; s: where or how fast an effect acts, by nodes.
By the truth with its continuous controller: a sampled one rounds, and differences would not be
smooth. All is smoothed by a Gaussian: a touch that comes earlier is two spikes as a difference, and
sums of such spikes, within a bin of what a diagnosis fits, are no machine. Kept on disk for each
truth.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks import truth
from benchmarks.naming_study.frozen import smallest
from benchmarks.oracle import APART
from benchmarks.oracle.bench import PLACE_STEP, STEP
from benchmarks.oracle.store import Store, digest
from benchmarks.truth.effects import CATALOGUE, SIZES
from benchmarks.truth.parameters import named
from benchmarks.truth.protocol import PROTOCOLS, Condition
from benchmarks.truth.record import posed
from benchmarks.truth.scatter import PLACES
from benchmarks.truth.simulation import trace
from hannes.plants.hand.plant import HandPlant

KEPT = Path("results/benchmarks/linearised")
TOLERANCE = 1e-5  # of a step of the truth
CONDITIONS = {each.name: each for each in PROTOCOLS["poor"].conditions}
FREE, PRESSED = ("position", "current"), ("position", "current", "force", "sensor")
GRAVITY_STEP = 0.5  # m/s2
NODES = 5  # of a shape parameter, log-uniform
SMOOTH = 10.0  # samples, standard deviation
TIMED = ("controller.", "encoder.")  # of a sampled controller
UNKNOWN = ("measurement_delay",)  # needs the sampled controller
Rows = np.ndarray


@dataclass(frozen=True)
class Shaped:
    """Change per unit of an amplitude beside a shape: nodes, shape (k,), and rows, (k, n).

    phased: whether a phase belongs to it; rows are then (k, 2, n), of its cosine and sine
    """

    name: str
    nodes: np.ndarray
    rows: np.ndarray
    phased: bool = False


@dataclass(frozen=True)
class Tangent:
    """Of a condition: names of channels, run and columns, rows of (channels x samples) each."""

    channels: tuple[str, ...]
    base: Rows
    values: Mapping[str, Rows]
    effects: Mapping[str, Rows | Shaped]


def names_of(condition: Condition) -> tuple[str, ...]:
    """Channels of a condition's runs."""
    return PRESSED if condition.sensor else FREE


@cache
def tangent(name: str) -> Tangent:
    """Of a condition of the poor protocol; simulated once, some minutes."""
    condition = CONDITIONS[name]
    store = Store(KEPT / digest(Path(truth.__file__).parent) / condition.stem)
    base = store.kept("base", lambda: run(condition, {}, {}))
    values = {n: store.kept(n, lambda n=n: _moved(condition, n, base)) for n in nominal()}
    effects = {n: _of_effect(store, condition, n, base) for n in amplitudes()}
    return Tangent(names_of(condition), base, values, effects)


@cache
def nominal() -> Mapping[str, float]:
    """Every value of the hand by full name, SI."""
    return dict(HandPlant().parameters)


def amplitudes() -> list[str]:
    """Full names of the amplitudes that have a column."""
    known = {each.__name__.rpartition(".")[2] for each in CATALOGUE} - set(UNKNOWN)
    return [n for n, s in SIZES.items() if s.amplitude and n.partition(".")[0] in known]


def run(
    condition: Condition, values: Mapping[str, float], effects: Mapping[str, float]
) -> np.ndarray:
    """Channels of a run without noise, one after another."""
    thing = condition.thing
    made, _ = trace(
        posed(named(values), thing),
        condition.points,
        object={"shape": thing["shape"]} if thing else None,
        duration=condition.duration,
        effects=effects,
        controller="continuous",
        tolerance=TOLERANCE,
    )
    channels = {column.rpartition("_")[0]: samples for column, samples in made.items()}
    return np.concatenate([smooth(channels[name]) for name in names_of(condition)])


def smooth(samples: np.ndarray) -> np.ndarray:
    """Samples without what is sharper than a bin."""
    from scipy.ndimage import gaussian_filter1d

    found: np.ndarray = gaussian_filter1d(samples, SMOOTH, mode="nearest")
    return found


def step_of(name: str) -> float:
    """By how much a value is moved; 0 where it is of the clock, or stands at 0 and is no place."""
    if name.startswith(TIMED):
        return 0.0
    if name in PLACES:
        return PLACE_STEP
    return GRAVITY_STEP if name in ("gravity.x", "gravity.y") else STEP * nominal()[name]


def _moved(condition: Condition, name: str, base: Rows) -> Rows:
    step = step_of(name)
    if not step:
        return np.zeros_like(base)
    try:
        changed = run(condition, {name: nominal()[name] + step}, {})
    except ValueError:  # this truth has it at no other value
        return np.zeros_like(base)
    return (changed - base) / step


def _of_effect(store: Store, condition: Condition, name: str, base: Rows) -> Rows | Shaped:
    """Per unit of an amplitude, over twice its smallest detectable size."""
    sizes = [each.u for each in smallest("poor", APART)[name] if each.u is not None]
    size = 2.0 * float(np.median(sizes))

    def kept(label: str, shape: Mapping[str, float]) -> Rows:
        def change() -> Rows:
            return (run(condition, {}, {name: size, **shape}) - base) / size

        return store.kept(f"{name}{label}", change)

    shapes = [n for n, s in SIZES.items()
              if n.partition(".")[0] == name.partition(".")[0] and not s.amplitude]  # fmt: skip
    return _shaped(kept, shapes) if shapes else kept("", {})


def _shaped(kept: Callable[[str, Mapping[str, float]], Rows], shapes: list[str]) -> Shaped:
    main, phases = shapes[0], [name for name in shapes if name.endswith(".phase")]
    low, high = SIZES[main].low, SIZES[main].high
    whole = main.endswith(".cycles")
    nodes = np.arange(low, high + 0.5) if whole else np.geomspace(low, high, NODES)
    if not phases:
        return Shaped(main, nodes, np.array([kept(f",{x:g}", {main: x}) for x in nodes]))
    ways = (0.0, 0.5 * np.pi)
    rows = [[kept(f",{x:g},{w:g}", {main: x, phases[0]: w}) for w in ways] for x in nodes]
    return Shaped(main, nodes, np.array(rows), True)
