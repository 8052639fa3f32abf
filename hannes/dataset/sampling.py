"""One grasp of a data set from its number: it depends on seed and number alone."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from hannes.core.errors import BadInput
from hannes.dataset.spec import OWN, Group, Spec
from hannes.simulation.experiment.clearance import DEEPEST, overlaps
from hannes.simulation.experiment.experiment import Experiment, Reference, Target
from hannes.simulation.hand.hand import Hand
from hannes.simulation.sensors import noisy
from hannes.simulation.trajectory import Grasp

MOST_TRIES = 2000  # samples of a grasp until its object stands clear of the open hand
SAMPLING, NOISE, EMPTY_NOISE = 0, 1, 2  # streams of random numbers


@dataclass(frozen=True)
class SampledGrasp:
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


def sample_grasp(spec: Spec, number: int) -> SampledGrasp:
    """Return grasp `number`; it is sampled again where its object intersects the open hand.

    Raises BadInput for a number that does not exist, and where no sample stands clear.
    """
    k, inside = spec.place(number)
    group = spec.groups[k]
    levels = group.levels(inside // group.draws)
    rng = np.random.default_rng(np.random.SeedSequence(spec.seed, spawn_key=(number, SAMPLING)))
    for _ in range(MOST_TRIES if any(each.kind for each in group.distributions.values()) else 1):
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
    sampled = {}
    for name in spec.columns:
        nominal = OWN[name][3] if name in OWN else spec.hand.parameters[name]
        distribution = group.distributions.get(name)
        sampled[name] = distribution.value(levels[name], nominal, rng) if distribution else nominal
    return sampled


def _made(spec: Spec, number: int, group: Group, values: dict[str, float]) -> SampledGrasp:
    """Hand and experiment with these values, each clipped to its bounds."""
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
    return SampledGrasp(number, group, values, spec.hand.with_values(own), experiment)


def emptied(spec: Spec, sampled: SampledGrasp) -> SampledGrasp:
    """The hand of a grasp that closes on nothing, by the command that `spec` has for that."""
    assert spec.empty is not None
    experiment = replace(
        sampled.experiment,
        title=f"{spec.title}, hand of grasp {sampled.number}",
        duration=float(spec.empty.knots[0, -1]),
        reference=spec.empty,
        object=None,
        seed=_seed(spec.seed, sampled.number, EMPTY_NOISE),
    )
    return replace(sampled, experiment=experiment)


def _seed(seed: int, number: int, stream: int = NOISE) -> int:
    sequence = np.random.SeedSequence(seed, spawn_key=(number, stream))
    return int(sequence.generate_state(1)[0])


def _commanded(reference: Reference, values: Mapping[str, float]) -> Reference:
    """The reference at `command.speed` times its speed, to `command.amplitude` times its angles.

    Beyond `command.knee` [rad] only `command.share` of its travel is left, as a grip policy does.
    """
    speed, amplitude = values.get("command.speed", 1.0), values.get("command.amplitude", 1.0)
    knee, share = values.get("command.knee", np.inf), values.get("command.share", 1.0)
    if speed == amplitude == share == 1.0:
        return reference
    scale = np.array([[amplitude / speed], [amplitude]])
    return Reference(_limited(reference.knots * scale, knee, share), reference.kinked)


def _limited(knots: np.ndarray, knee: float, share: float) -> np.ndarray:
    """Knots (2, n) of a reference whose travel beyond `knee` [rad] counts for `share` only."""
    times, angles = knots
    above = angles > knee
    if share == 1.0 or not above.any():
        return knots
    crossed = np.flatnonzero(above[1:] != above[:-1])
    part = (knee - angles[crossed]) / (angles[crossed + 1] - angles[crossed])
    moments = times[crossed] + part * (times[crossed + 1] - times[crossed])
    times = np.insert(times, crossed + 1, moments)
    angles = np.insert(angles, crossed + 1, knee)
    return np.stack([times, np.where(angles > knee, knee + share * (angles - knee), angles)])


def rounded(values: np.ndarray, step: float) -> np.ndarray:
    """The nearest multiples of a sensor's resolution; the values themselves where it is 0."""
    return step * np.round(values / step) if step > 0.0 else values


def sensed(sampled: SampledGrasp, grasp: Grasp, name: str) -> np.ndarray:
    """Values that the sensor of a channel logs: with noise, then with its resolution."""
    values = noisy(sampled.experiment, name, grasp[name])
    return rounded(values, sampled.values.get(f"resolution.{name}", 0.0))
