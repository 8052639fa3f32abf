"""What is hidden in each case of `guards`, by its seed alone."""

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.naming_study.draw import amplitudes
from benchmarks.study import Case
from benchmarks.truth.campaign import Spread
from benchmarks.truth.effects import CATALOGUE, SIZES
from benchmarks.truth.protocol import PROTOCOLS, Protocol

SPREAD = Spread(finger=0.01)  # each joint is off for itself, too
SHIPPED = {"void": "void-closure", "dynamometer": "dynamometer"}  # condition -> experiment
AGAIN, FRESH = "again ", 4  # runs of each condition that the campaign does not hold
LEAST_SHARE = 0.1  # of an effect's range, that a large one has at least
# First seeds. Those from 320, 330 and 350 million showed faults, and count as development.
SETS = {"development": 310_000_000, "quoted": 370_000_000}
APART = 1000  # seeds between kinds
STREAM = 48  # of random numbers


@dataclass(frozen=True)
class Kind:
    """Cases whose user states his scatter or nothing; counts: whole, quick."""

    name: str
    large: bool
    stated: bool
    counts: tuple[int, int]


KINDS = (
    Kind("large effect, stated", True, True, (12, 0)),
    Kind("large effect, nothing stated", True, False, (5, 0)),
    Kind("sound, stated", False, True, (8, 0)),
    Kind("sound, nothing stated", False, False, (5, 1)),
)
NAMED = {kind.name: kind for kind in KINDS}


def cases(chosen: str, quick: bool) -> list[Case]:
    """Name of kind and seed of every case of a set; kinds take turns."""
    found = [
        ((k + 0.5) / kind.counts[quick], (kind.name, SETS[chosen] + APART * number + k))
        for number, kind in enumerate(KINDS)
        for k in range(kind.counts[quick])
    ]
    return [case for _, case in sorted(found, key=lambda each: each[0])]


def hidden(kind: Kind, seed: int) -> dict[str, float]:
    """Sizes by full name: an effect at a tenth to the end of its range, log-uniform; or none."""
    if not kind.large:
        return {}
    rng, names = np.random.default_rng([seed, STREAM]), amplitudes(CATALOGUE)
    name = str(names[rng.integers(len(names))])
    high = SIZES[name].high
    size = high * LEAST_SHARE ** rng.uniform()
    return {name: size * (rng.choice([-1.0, 1.0]) if SIZES[name].low < 0.0 else 1.0)}


def plan() -> Protocol:
    """The poor protocol, and its runs again after them."""
    poor = PROTOCOLS["poor"]
    more = [replace(each, name=AGAIN + each.name, repeats=FRESH) for each in poor.conditions]
    return replace(poor, conditions=(*poor.conditions, *more))
