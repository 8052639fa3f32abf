"""Campaigns of a hand whose nine named parameters lie 20 % off, made by the independent truth.

All else of the hand, those of the nine that he does not ask for too, is as the analyst believes it;
every run scatters it anew (see benchmarks/truth/scatter.py).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.truth import campaign as truth
from benchmarks.truth.fitness import fit
from benchmarks.truth.parameters import parse_hand
from benchmarks.truth.protocol import (
    DYNAMOMETER,
    PAPER,
    PROTOCOLS,
    RICH,
    SOFT_BALL,
    Condition,
    Protocol,
    closures,
    scaled,
)
from hannes.campaigns.campaign import Campaign, Entry
from hannes.core.io.toml_table import Table
from hannes.core.io.units import text
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.hand.hand import Hand

NINE = (
    "motor.torque_constant",
    "motor.resistance",
    "motor.dry_friction",
    "mcp.coulomb_friction",
    "pip.coulomb_friction",
    "mcp.spring_stiffness",
    "gear.pulley_radius",
    "object.stiffness",
    "object.friction",
)
# Quick runs only, three of each: a campaign that can be made and fitted hundreds of times.
QUICK = Protocol(
    (
        *closures(3).conditions,
        Condition("dynamometer, full speed", PAPER, 3, DYNAMOMETER, sensor=True),
        Condition("dynamometer, 0.85 amplitude", scaled(PAPER, 1.0, 0.85), 3, DYNAMOMETER, True),
        Condition("soft ball", PAPER, 3, SOFT_BALL),
    ),
    RICH,
)
RICH_PROTOCOL = PROTOCOLS["rich"]
ONE_RUN = Protocol((Condition("dynamometer", PAPER, 1, DYNAMOMETER, sensor=True),), RICH)
SPREAD, CUT = 0.2, 2.5  # relative, and standard deviations beyond which a value is drawn again
STREAM = 77  # of random numbers


@dataclass(frozen=True)
class Case:
    """A campaign as the analyst has it, and the values that are hidden from him."""

    campaign: Campaign
    true: dict[str, float]


def scattered(seed: int, names: tuple[str, ...] = NINE) -> dict[str, float]:
    """True values of those of the nine that are in `names`, of a hand that still grasps."""
    rng, shipped = np.random.default_rng([seed, STREAM]), Hand().parameters
    while True:
        z = rng.standard_normal(len(NINE))
        if np.abs(z).max() > CUT:
            continue
        values = {
            name: float(shipped[name] * (1.0 + SPREAD * k))
            for name, k in zip(NINE, z, strict=True)
            if name in names
        }
        if fit(parse_hand(hand_text(values))):
            return values


def hand_text(values: Mapping[str, float]) -> str:
    """A hand.toml with these values."""
    declared = Hand().parameters.declared
    lines = [f'"{name}" = "{text(x, declared[name].unit)}"' for name, x in values.items()]
    return "\n".join(['base = "hannes"', "[parameters]", *lines]) + "\n"


def case(
    seed: int,
    parameters: tuple[str, ...] = NINE,
    protocol: Protocol = RICH_PROTOCOL,
    hidden: Mapping[str, float] | None = None,
    starts: int = 1,
    rest: float = 0.0,
    limit: float = 0.1,
) -> Case:
    """A campaign under `protocol`, with the shipped hand as the analyst's belief.

    `rest` is how far (relative, one standard deviation) all else of the hand lies off, which the
    analyst then says, and that the values asked for are guesses; `limit` the relative half-width
    up to which a value is of use to him.
    """
    values = scattered(seed, parameters)
    made = truth.make(protocol, seed, hidden, truth.Spread(hand=rest), hand_text(values))
    entries = tuple(
        Entry(name, recording, made.conditions[name], "fit")
        for name, recording in made.recordings.items()
    )
    asked = {"parameters": list(parameters), "starts": starts, "limit": f"{100.0 * limit:g} %"}
    asked |= {"doubt": f"{100.0 * rest:g} %", "doubt_apart": "0 %"}
    asked |= {"spread": dict.fromkeys(parameters, f"{100.0 * SPREAD:g} %")} if rest else {}
    plant = HandPlant()
    table = Table(asked, "calibrate", ())
    campaign = Campaign(plant, plant, entries, Path("results"), {}, "known", calibrate=table)
    real = {**dict(Hand().parameters), **values, **made.answer["hand"]}
    return Case(campaign, {name: float(real[name]) for name in parameters})
