"""One grasp of a data set from its number: what it is made of hangs on seed and number alone."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from hannes.core.errors import BadInput
from hannes.dataset.spec import OWN, Group, Spec
from hannes.simulation.experiment.clearance import DEEPEST, overlaps
from hannes.simulation.experiment.experiment import Experiment, Reference, Target
from hannes.simulation.hand.hand import Hand

MOST_TRIES = 2000  # draws of a grasp until its object stands clear of the open hand
DRAWN, NOISED = 0, 1  # streams of random numbers


@dataclass(frozen=True)
class Drawn:
    """A grasp to be simulated; `values` (SI) has every column of the data set."""

    number: int
    group: Group
    values: Mapping[str, float]
    hand: Hand
    experiment: Experiment

    @property
    def seed(self) -> int:
        """Seed of its sensors' noise."""
        return self.experiment.seed


def draw(spec: Spec, number: int) -> Drawn:
    """Return a grasp; draws whose object intersects the open hand are drawn again.

    Raises BadInput for a number that is not there and where no draw stands clear.
    """
    k, inside = spec.place(number)
    group = spec.groups[k]
    levels = group.levels(inside // group.draws)
    rng = np.random.default_rng(np.random.SeedSequence(spec.seed, spawn_key=(number, DRAWN)))
    for _ in range(MOST_TRIES if any(law.kind for law in group.laws.values()) else 1):
        made = _made(spec, number, group, _values(spec, group, levels, rng))
        depths = overlaps(made.hand, made.experiment)
        worst = max(depths, key=depths.__getitem__, default="")
        if not worst or depths[worst] <= DEEPEST:
            return made
    raise BadInput(
        f"grasp {number} ({group.name}): the object intersects the open hand, the {worst} by "
        f"{1e3 * depths[worst]:.1f} mm at the last of its draws; move it, or make it smaller"
    )


def _values(
    spec: Spec, group: Group, levels: Mapping[str, int], rng: np.random.Generator
) -> dict[str, float]:
    drawn = {}
    for name in spec.columns:
        nominal = OWN[name][3] if name in OWN else spec.hand.parameters[name]
        law = group.laws.get(name)
        drawn[name] = law.value(levels[name], nominal, rng) if law else nominal
    return drawn


def _made(spec: Spec, number: int, group: Group, values: dict[str, float]) -> Drawn:
    """Hand and experiment with these values; what a spread takes out of bounds is put on them."""
    known = spec.hand.parameters.declared
    for name in values.keys() & known.keys():
        low, high = known[name].bounds
        values[name] = min(max(values[name], low), high)
    placed = {name: x for name, x in values.items() if name.startswith("object.")}
    own = {name: x for name, x in values.items() if name in known and name not in placed}
    noise = {name: values.get(f"noise.{name}", 0.0) for name in spec.channels}
    experiment = replace(
        spec.base,
        title=f"{spec.title}, grasp {number}",
        reference=_commanded(spec.base.reference, values),
        object=Target(group.shape, placed, "sensor" in spec.channels) if group.shape else None,
        noise={name: x for name, x in noise.items() if x > 0.0},
        seed=_seed(spec.seed, number),
    )
    return Drawn(number, group, values, spec.hand.with_values(own), experiment)


def _seed(seed: int, number: int) -> int:
    sequence = np.random.SeedSequence(seed, spawn_key=(number, NOISED))
    return int(sequence.generate_state(1)[0])


def _commanded(reference: Reference, values: Mapping[str, float]) -> Reference:
    """The reference at `command.speed` times its speed, to `command.amplitude` times its angles."""
    speed, amplitude = values.get("command.speed", 1.0), values.get("command.amplitude", 1.0)
    if speed == amplitude == 1.0:
        return reference
    scale = np.array([[amplitude / speed], [amplitude]])
    return Reference(reference.knots * scale, reference.kinked)


def rounded(values: np.ndarray, step: float) -> np.ndarray:
    """The nearest multiples of a sensor's resolution; the values themselves where it is 0."""
    return step * np.round(values / step) if step > 0.0 else values
