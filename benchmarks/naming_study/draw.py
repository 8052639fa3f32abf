"""What is hidden in a case, drawn by its seed alone.

Sizes are log-uniform between half and five times the minimum detectable size u, inside the physical
range. A size that is not detectable within that range is drawn near its end, and counts as not
nameable. Shape parameters, such as where or how fast an effect acts, take one of the shapes for
which u is known.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.naming_study.frozen import Smallest, smallest
from benchmarks.truth.effects import CATALOGUE, OUTSIDE, SIZES
from benchmarks.truth.protocol import POOR, PROTOCOLS, Condition, Protocol, closures, scaled
from hannes.plants.hand.candidate_runs import CHANGES

PLANS: dict[str, Protocol] = {
    **PROTOCOLS,
    "poor, duty": replace(PROTOCOLS["poor"], channels=(*POOR, "duty_1")),
    "closures": closures(6),
}
# What may be recorded in addition to the poor protocol, once: all else that the rich one has.
MENU = {
    each.name: replace(each, repeats=1)
    for each in PROTOCOLS["rich"].conditions
    if (each.points, each.thing) not in [(c.points, c.thing) for c in PROTOCOLS["poor"].conditions]
}
# What the bench can do: that, and all runs of the poor protocol as a verdict may propose them.
BENCH = {
    f"{each.name}, {change}": Condition(
        f"{each.name}, {change}", scaled(each.points, *shares), 1, each.thing, each.sensor
    )
    for each in PROTOCOLS["poor"].conditions
    for change, shares in CHANGES.items()
} | MENU
LOGGED = {"duty": "duty_1"}  # channels that the bench could log too, as it calls them
LEAST, MOST = 0.5, 5.0  # times u
PAIRED = 2.0  # times u, of each of a pair, at least
SLACK = (1e-3, 6e-3)  # m, in free closures like the paper's figure 7
STREAM = 41  # of random numbers
# Seeds take effects in this order: it fixes every case. An effect that comes later joins a new
# study, for which all sizes are frozen anew (python -m benchmarks.oracle).
ORDER = (
    *("leader_slack", "wire_compliance", "capstan", "gear_load", "direction_friction", "stribeck"),
    *("gear_backlash", "torque_ripple", "winding_heating", "supply_sag", "pwm_dead_band"),
    *("spring_error", "spring_hysteresis", "hunt_crossley", "viscoelastic_object"),
    *("object_misplacement", "current_offset", "current_gain", "current_lag", "force_lag"),
    *("command_delay", "measurement_delay"),
    *("friction_step", "nonlinear_spring", "eccentric_pulley", "jammed_finger", "wire_creep"),
)


@dataclass(frozen=True)
class Drawn:
    """hidden: SI sizes by full name, shapes included; times: each amplitude's size over its u.

    A u beyond the physical range gives None, as do free closures, for which no oracle was asked.
    """

    hidden: dict[str, float]
    times: dict[str, float | None]

    @property
    def least_times(self) -> float | None:
        """Size over u of the hardest to see; None where nothing is nameable."""
        times = list(self.times.values())
        return min(times) if times and None not in times else None

    @property
    def effects(self) -> list[str]:
        """Names of what is hidden."""
        return [name.partition(".")[0] for name in self.times]


def drawn(what: str, protocol: str, seed: int) -> Drawn:
    """what: "single", "pair", "outside", "closures" or "empty".

    Seeds that follow each other take the parameters in turn, so that each is hidden as often.
    """
    rng = np.random.default_rng([seed, STREAM])
    if what == "empty":
        return Drawn({}, {})
    if what == "closures":
        return Drawn({"leader_slack.length": _log(rng, *SLACK)}, {"leader_slack.length": None})
    names = amplitudes(OUTSIDE if what == "outside" else CATALOGUE)
    first = names[seed % len(names)]
    if what != "pair":
        return _hidden([first], protocol, LEAST, rng)
    seen = [name for name in names if _shapes(name, protocol, PAIRED)]
    first = seen[seed % len(seen)]
    others = [name for name in seen if name.partition(".")[0] != first.partition(".")[0]]
    return _hidden([first, str(rng.choice(others))], protocol, PAIRED, rng)


def with_run(plan: Protocol, name: str, also: Sequence[str] = ()) -> Protocol:
    """A protocol and one more run of the bench: all runs before it stay what they are.

    also: channels logged in that run alone
    """
    run = replace(BENCH[name], also=tuple(LOGGED[each] for each in also))
    return replace(plan, conditions=(*plan.conditions, run))


def any_run(seed: int) -> str:
    """A run of the menu, by chance."""
    return str(np.random.default_rng([seed, STREAM, 1]).choice(sorted(MENU)))


def amplitudes(effects: tuple) -> list[str]:
    """Full names of all amplitudes of effects, in the order of the study."""
    known = {effect.__name__.rpartition(".")[2] for effect in effects}
    return [
        name
        for effect in ORDER
        for name, size in SIZES.items()
        if effect in known and size.amplitude and name.partition(".")[0] == effect
    ]


def _hidden(names: list[str], protocol: str, least: float, rng: np.random.Generator) -> Drawn:
    hidden: dict[str, float] = {}
    times: dict[str, float | None] = {}
    for name in names:
        size, known = SIZES[name], _shapes(name, protocol, least if len(names) > 1 else 0.0)
        drawn = known[rng.integers(len(known))]
        u = drawn.u
        low, high = (0.3 * size.high, size.high) if u is None else (least * u, MOST * u)
        amount = _log(rng, min(low, size.high), min(high, size.high))
        times[name] = None if u is None else amount / u
        hidden[name] = amount * (rng.choice([-1.0, 1.0]) if size.low < 0.0 else 1.0)
        hidden |= drawn.shape
    return Drawn(hidden, times)


def _shapes(name: str, protocol: str, times: float) -> list[Smallest]:
    """Shapes of an effect; of a pair those that may be so many times u within the range."""
    known, most = smallest(protocol)[name], SIZES[name].high
    return [s for s in known if not times or (s.u is not None and times * s.u <= most)]


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(low * (high / low) ** rng.uniform())
