"""What is hidden in a case, drawn by its kind and its seed alone.

A draw that cannot be made, or does not show where it must, is drawn again: `attempt` counts. The
first ones keep the third of the range and the name whose turn it is; then the third is free; then
the next name has its turn.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from benchmarks.naming_study.apart import sizes
from benchmarks.naming_study.apart.kinds import Kind, is_quoted, place
from benchmarks.naming_study.apart.sizes import Range
from benchmarks.truth.effects import OPENED, SEALED
from benchmarks.truth.faults import RANGES as FAULTS
from benchmarks.truth.faults import Fault
from benchmarks.truth.parameters import FINGERS

SAME_THIRD, SAME_NAME = 4, 8  # attempts
MOST_ATTEMPTS = 24
MUJOCO = {  # what MuJoCo's own elements can hide
    "MuJoCo sound": (),
    "MuJoCo slack": ("leader_slack.length",),
    "MuJoCo load": ("gear_load.coefficient",),
}
TOGETHER = {"single": 1, "pair": 2, "triple": 3}
BANDWIDTHS = (30.0, 300.0)  # Hz, of coloured noise
JOINTS = ("mcp", "pip")
STREAM = 53  # of random numbers


@dataclass(frozen=True)
class Hidden:
    """sizes: SI by full name, shapes included; times: of each amplitude, over its u.

    bandwidth: of the current sensor's noise (Hz), None where it is white
    """

    sizes: dict[str, float] = field(default_factory=dict)
    times: dict[str, float] = field(default_factory=dict)
    fault: Fault | None = None
    bandwidth: float | None = None

    @property
    def effects(self) -> list[str]:
        """Names of what is hidden, as a verdict would have them."""
        if self.fault:
            return [f"{self.fault.finger}_{self.fault.kind}"]
        return list(dict.fromkeys(name.partition(".")[0] for name in self.sizes))


def drawn(kind: Kind, seed: int, attempt: int = 0) -> Hidden:
    """What a case hides. Raises ValueError for a sealed kind outside the quoted set."""
    rng = np.random.default_rng([seed, STREAM, attempt])
    if kind.what == "sound":
        return Hidden(bandwidth=_log(rng, *BANDWIDTHS) if kind.coloured else None)
    if kind.what == "fault":
        return Hidden(fault=_fault(seed, attempt, rng))
    if kind.what == "MuJoCo sound":
        return Hidden()
    if kind.what == "sealed" and not is_quoted(seed):
        raise ValueError("sealed kinds are hidden by the quoted set alone")
    if kind.what in ("opened", "sealed"):
        known = sizes.outside(OPENED if kind.what == "opened" else SEALED)
    else:
        known = sizes.named(kind.protocol)
    if kind.what in MUJOCO:
        known = {name: known[name] for name in MUJOCO[kind.what]}
    return _several(known, TOGETHER.get(kind.what, 1), seed, attempt, rng)


def _several(
    known: Mapping[str, list[Range]], count: int, seed: int, attempt: int, rng: np.random.Generator
) -> Hidden:
    """So many different effects: the first by its turn, the others by chance."""
    names = [_turn(list(known), seed, attempt)]
    while len(names) < count:
        taken = {name.partition(".")[0] for name in names}
        free = [name for name in known if name.partition(".")[0] not in taken]
        names.append(str(rng.choice(free)))
    found, times = {}, {}
    for number, name in enumerate(names):
        one = known[name][rng.integers(len(known[name]))]
        found[name] = one.at(sizes.share(rng, _third(seed, attempt, number)))
        found |= one.shape
        times |= {} if one.u is None else {name: abs(found[name]) / one.u}
    return Hidden(found, times)


def _turn(names: list[str], seed: int, attempt: int) -> str:
    return sizes.turn(names, seed - place(seed), place(seed) + attempt // SAME_NAME)


def _third(seed: int, attempt: int, number: int = 0) -> int | None:
    return sizes.third(seed, place(seed), number) if attempt < SAME_THIRD else None


def _fault(seed: int, attempt: int, rng: np.random.Generator) -> Fault:
    """A fault of a finger's joint; kinds take turns."""
    kind = _turn(list(FAULTS), seed, attempt)
    low, high = sorted(FAULTS[kind], key=abs)
    size = low * (high / low) ** sizes.share(rng, _third(seed, attempt))
    return Fault(kind, str(rng.choice(FINGERS)), str(rng.choice(JOINTS)), float(size))


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(low * (high / low) ** rng.uniform())
