"""One experiment into several: a sweep over given values, a scatter over virtual hands."""

import itertools
import math
import re
from dataclasses import dataclass, replace

import numpy as np

from hannes.core.io.toml_table import Table
from hannes.core.io.units import quantity
from hannes.simulation.experiment.experiment import CONTROLLERS, Experiment, Target
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import checked, declared

MOST = 200  # variants of one experiment
SCATTER = ("hands", "seed", "spread")
PLACE = ("object.x", "object.y", "object.z")


@dataclass(frozen=True)
class Variant:
    """One simulation of an experiment; `name` distinguishes it from its siblings, or is ""."""

    name: str
    hand: Hand
    experiment: Experiment

    @property
    def file(self) -> str:
        """Name of its recording: recording.h5, or recording-<variant>.h5."""
        signed = re.sub(r"(?<![a-z0-9.])-(?=[0-9.])", "minus ", self.name.lower())
        slug = re.sub(r"[^a-z0-9.]+", "-", signed).strip("-.")
        return f"recording-{slug}.h5" if slug else "recording.h5"


def expanded(hand: Hand, experiment: Experiment, root: Table) -> list[Variant]:
    """Return the variants that the tables `[sweep]` and `[scatter]` ask for, at least one."""
    sweep, scatter = root.table("sweep"), root.table("scatter", SCATTER)
    if sweep.content and scatter.content:
        root.refuse("sweep", "cannot stand beside [scatter]; keep one of them")
    if sweep.content:
        return _numbered(_swept(Variant("", hand, experiment), sweep))
    if scatter.content:
        return _numbered(_scattered(hand, experiment, scatter))
    return [Variant("", hand, experiment)]


def _numbered(variants: list[Variant]) -> list[Variant]:
    """Give every variant noise of its own, the same for any order or number of workers."""
    return [
        replace(each, experiment=replace(each.experiment, seed=_seed(each.experiment.seed, k)))
        for k, each in enumerate(variants)
    ]


def _seed(seed: int, number: int) -> int:
    drawn = np.random.SeedSequence(seed, spawn_key=(number,)).generate_state(1)
    return int(drawn[0])


def _swept(start: Variant, sweep: Table) -> list[Variant]:
    keys = [[(key, each) for each in sweep.items(key)] for key in sweep.content]
    count = math.prod(len(values) for values in keys)
    if not 1 <= count <= MOST:
        sweep.refuse(next(iter(sweep.content)), f"makes {count} variants; expected 1 to {MOST}")
    found = []
    for choice in itertools.product(*keys):
        variant = replace(start, name=", ".join(str(each) for _, each in choice))
        for key, each in choice:
            variant = _with(variant, key, each, sweep)
        found.append(variant)
    if len({each.file for each in found}) < count:
        sweep.refuse(next(iter(sweep.content)), "gives the same value twice")
    return found


def _with(variant: Variant, key: str, given: object, sweep: Table) -> Variant:
    """Return `variant` with one swept value in its place: controller, object or hand."""
    if key == "controller":
        chosen = Table({key: given}, sweep.where, (key,), sweep.prefix).choice(key, CONTROLLERS)
        return replace(variant, experiment=replace(variant.experiment, controller=chosen))
    number = checked(given, declared(key, variant.hand, sweep), sweep)
    if not key.startswith("object."):
        return replace(variant, hand=variant.hand.with_values({key: number}))
    target = variant.experiment.object
    if target is None:
        sweep.refuse(key, "cannot be swept: the experiment has no [object]")
    moved = Target(target.shape, {**_placed(variant, key), key: number}, target.sensor)
    return replace(variant, experiment=replace(variant.experiment, object=moved))


def _placed(variant: Variant, key: str) -> dict[str, float]:
    """Values of the object, with all three coordinates where one of them is swept."""
    values = dict(variant.experiment.object.values) if variant.experiment.object else {}
    if key in PLACE:
        values = {**{name: variant.hand.parameters[name] for name in PLACE}, **values}
    return values


def _scattered(hand: Hand, experiment: Experiment, scatter: Table) -> list[Variant]:
    count, seed = scatter.whole("hands", 1, MOST), scatter.whole("seed", 0, 2**32 - 1, 0)
    spread = _spread(hand, scatter)
    return [
        Variant(f"virtual hand {k + 1}", _drawn(hand, spread, seed, k, scatter), experiment)
        for k in range(count)
    ]


def _spread(hand: Hand, scatter: Table) -> dict[str, float]:
    """Relative standard deviation by full name of a parameter that is not zero."""
    scatter.require("spread", '{ "motor.dry_friction" = "0.1" }')
    table, found = scatter.table("spread"), {}
    for name, given in table.content.items():
        declared(name, hand, table)
        found[name] = quantity(given, "1", table.name(name))
        if not 0.0 <= found[name] <= 1.0:
            table.refuse(name, f"= {found[name]:g}: expected a relative spread from 0 to 1")
        if hand.parameters[name] == 0.0:
            table.refuse(name, "is zero in this hand: a relative spread would not move it")
    return found


def _drawn(hand: Hand, spread: dict[str, float], seed: int, number: int, table: Table) -> Hand:
    """Return one virtual hand: each value times exp(spread z), z standard normal, in bounds."""
    generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    drawn = generator.standard_normal(len(spread))
    values = {
        name: hand.parameters[name] * math.exp(sigma * z)
        for (name, sigma), z in zip(spread.items(), drawn, strict=True)
    }
    low_high = {name: hand.parameters.declared[name].bounds for name in values}
    return hand.with_values(
        {n: min(max(x, low_high[n][0]), low_high[n][1]) for n, x in values.items()}
    )
