"""The recordings of a case: made by the truth, written as its user would."""

import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.guarding.plan import SHIPPED, SPREAD
from benchmarks.naming_study.apart import mujoco_bench
from benchmarks.naming_study.apart.draw import MOST_ATTEMPTS, MUJOCO, Hidden, drawn
from benchmarks.naming_study.apart.kinds import Kind
from benchmarks.truth.campaign import Made, make
from benchmarks.truth.protocol import (
    DYNAMOMETER,
    PAPER,
    PROTOCOLS,
    Condition,
    Protocol,
    scaled,
)
from hannes.core.errors import ComputationFailed

PLANS: Mapping[str, Protocol] = {**PROTOCOLS, "naive": PROTOCOLS["poor"]}
ELSEWHERE = (  # commands that no protocol has: recorded, not given
    Condition("void, 0.3 speed", scaled(PAPER, 0.3), 4),
    Condition("void, 0.7 amplitude", scaled(PAPER, 1.0, 0.7), 4),
    Condition("dynamometer, half speed", scaled(PAPER, 0.5), 4, DYNAMOMETER, sensor=True),
    Condition("dynamometer, 0.7 amplitude", scaled(PAPER, 1.0, 0.7), 4, DYNAMOMETER, sensor=True),
)
OTHER = tuple(each.name for each in ELSEWHERE)
OUTSIDE = ("opened", "sealed")
MUST_SHOW = (*OUTSIDE, "fault")
SHOWS = 3.0  # noise floors


@dataclass(frozen=True)
class Case:
    """What is hidden, the recordings, and by how many noise floors it shows (None: not asked)."""

    hidden: Hidden
    made: Made
    shows: float | None = None


def case(kind: Kind, seed: int) -> Case:
    """A case's recordings; drawn again until they can be made, and show where they must.

    Raises ComputationFailed after `MOST_ATTEMPTS`.
    """
    if kind.what in MUJOCO:
        hidden = drawn(kind, seed)
        return Case(hidden, mujoco_bench.make(seed, hidden.sizes))
    plan = PLANS[kind.protocol]
    plan = replace(plan, conditions=(*plan.conditions, *_beside(kind)))
    sound = make(plan, seed, spread=SPREAD) if kind.what in MUST_SHOW else None
    for attempt in range(MOST_ATTEMPTS):
        hidden = drawn(kind, seed, attempt)
        try:
            made = make(plan, seed, hidden.sizes, SPREAD, fault=hidden.fault,
                        bandwidth=hidden.bandwidth)  # fmt: skip
        except ComputationFailed:
            continue
        shows = None if sound is None else shown(made, sound)
        if shows is None or shows > SHOWS:
            return Case(hidden, made, shows)
    raise ComputationFailed(f"nothing that shows after {MOST_ATTEMPTS} draws")


def _beside(kind: Kind) -> tuple[Condition, ...]:
    return ELSEWHERE if kind.what in OUTSIDE else ()


def shown(made: Made, sound: Made) -> float:
    """RMS of what changed, over the noise floor: of the channel and command where it is largest.

    Both are of one hand on the same noise: the difference of means over repeats has none. The
    floor is how far runs of the sound one differ from their mean. Commands that are not given do
    not count.
    """
    found = 0.0
    for condition in set(made.conditions.values()) - set(OTHER):
        runs = [name for name, of in made.conditions.items() if of == condition]
        for channel in set(sound.recordings[runs[0]].channels) - {"time", "reference"}:
            one, other = (
                np.array([each.recordings[run][channel] for run in runs]) for each in (made, sound)
            )
            change = np.sqrt(np.mean((one.mean(axis=0) - other.mean(axis=0)) ** 2))
            floor = np.sqrt(np.mean(np.var(other, axis=0, ddof=1)))
            found = max(found, float(change / floor) if floor > 0.0 else 0.0)
    return found


def written(made: Made, stated: bool, folder: Path) -> Path:
    """The campaign file as a user who states scatter and experiments writes it, or one who states
    nothing; without commands that are not given, and without the answer.
    """
    kept = {n: c for n, c in made.conditions.items() if c not in OTHER}
    given = replace(made, conditions=kept, recordings={n: made.recordings[n] for n in kept})
    if stated:
        given.write(folder)
        shutil.rmtree(folder / "sealed")
    else:
        given.write_unstated(folder, SHIPPED)
    return folder / "campaign.toml"
