"""What a scattered hand does on average: nothing that differs from run to run but noise."""

from collections.abc import Iterable, Mapping

import numpy as np

from benchmarks.truth import bench
from benchmarks.truth.campaign import SHIPPED, Spread, real_hand, real_object
from benchmarks.truth.hidden import of_effects
from benchmarks.truth.parameters import parse_hand
from benchmarks.truth.protocol import Condition, Protocol
from benchmarks.truth.record import posed
from benchmarks.truth.settings import set_otherwise
from benchmarks.truth.simulation import trace

STREAM = 3  # of random numbers


def expected(
    plan: Protocol,
    seed: int,
    hidden: Mapping[str, float],
    names: Iterable[str],
    draws: int,
    spread: Spread | None = None,
) -> dict[str, list[dict[str, np.ndarray]]]:
    """Name of condition -> `draws` runs, channel -> samples, of the hand that `make` makes.

    They differ in the noise of the current, which moves the hand. Raises RuntimeError where a run
    does not end.
    """
    spread = spread or Spread()
    hand = set_otherwise(real_hand(parse_hand(SHIPPED), seed, spread)[0], hidden)
    wanted = {each.name: each for each in plan.conditions}
    found: dict[str, list[dict[str, np.ndarray]]] = {}
    for name in names:
        thing = real_object(hand, wanted[name], seed, spread)
        values = {**posed(hand, thing), "controller.current_step": bench.CURRENT_STEP}
        found[name] = [
            _run(values, wanted[name], thing, hidden, np.random.default_rng([seed, STREAM, k]))
            for k in range(draws)
        ]
    return found


def _run(
    values: Mapping[str, object],
    condition: Condition,
    thing: Mapping[str, object] | None,
    hidden: Mapping[str, float],
    rng: np.random.Generator,
) -> dict[str, np.ndarray]:
    channels, _ = trace(
        values,
        condition.points,
        object={"shape": thing["shape"]} if thing else None,
        duration=condition.duration,
        effects=of_effects(hidden),
        current_noise=bench.CURRENT * rng.standard_normal(round(condition.duration * 1000) + 1),
    )
    return {name.rpartition("_")[0]: samples for name, samples in channels.items()}
