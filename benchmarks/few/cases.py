"""Small campaigns as a lab's first hour makes them: 1 to 3 conditions of 2 to 5 runs.

A third is sound, of a third something is hidden that the model lacks, of a third a logger's fault
is in the recordings. Every value of the hand is 1.5 % off what the analyst believes, each joint
0.75 % for itself besides. A third of the analysts state nothing: not that their firmware samples.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from benchmarks.few.faults import KINDS as FAULTS
from benchmarks.naming_study.draw import amplitudes
from benchmarks.naming_study.frozen import smallest
from benchmarks.truth import campaign as truth
from benchmarks.truth.effects import CATALOGUE, SIZES
from benchmarks.truth.protocol import (
    DYNAMOMETER,
    PAPER,
    RICH,
    SOFT_BALL,
    Condition,
    Protocol,
    closures,
    scaled,
)
from hannes.campaigns.campaign import Campaign, Entry
from hannes.core.io.toml_table import Table
from hannes.core.recording.recording import Recording
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.catalogue import effects
from hannes.simulation.hand.hand import Hand

KINDS = ("sound", "missing", "fault")
SPREAD = truth.Spread(hand=0.015, finger=0.0075)
FULL = closures(1).conditions[0]
POOL = (
    FULL,
    Condition("dynamometer", PAPER, 1, DYNAMOMETER, sensor=True),
    Condition("dynamometer, 0.85 amplitude", scaled(PAPER, 1.0, 0.85), 1, DYNAMOMETER, True),
    Condition("closure to 10 rad", PAPER, 1),
    Condition("closure, half speed", scaled(PAPER, 0.5), 1),
    Condition("soft ball", PAPER, 1, SOFT_BALL),
)
# What is asked for: of the drive by any run, of the object by a grasp of it.
ASKED = (
    *("motor.torque_constant", "motor.resistance", "motor.dry_friction", "gear.pulley_radius"),
    *("mcp.spring_stiffness", "mcp.spring_preload", "pip.spring_preload", "mcp.moment_arm"),
    *("motor.viscous_friction", "mcp.coulomb_friction"),
)
OF_OBJECT = ("object.stiffness", "object.friction")
TIMES = (2.0, 12.0)  # of the smallest size that a rich protocol shows
STREAM = 97  # of random numbers


@dataclass(frozen=True)
class Case:
    """A campaign as the analyst has it, and what he does not know.

    plain: where something is missing, the same recordings by the same hand without it
    """

    campaign: Campaign
    true: dict[str, float]
    kind: str
    hidden: dict[str, float]
    fault: str
    stated: bool
    protocol: Protocol
    plain: dict[str, Recording] = field(default_factory=dict, repr=False)


def case(seed: int) -> Case:
    """The case of a seed: kinds take turns, and a third of each states nothing."""
    rng = np.random.default_rng([seed, STREAM])
    kind, stated = KINDS[seed % 3], (seed // 3) % 3 != 0
    protocol = _protocol(rng)
    names = _asked(rng, protocol)
    hidden = _hidden(rng, seed) if kind == "missing" else {}
    fault = sorted(FAULTS)[(seed // 3) % len(FAULTS)] if kind == "fault" else ""
    made = truth.make(protocol, seed, hidden, SPREAD)
    entries = []
    for k, (name, recording) in enumerate(made.recordings.items()):
        changed = FAULTS[fault](recording, k) if fault else recording
        changed = changed if stated else _unsaid(changed)
        entries.append(Entry(name, changed, made.conditions[name], "fit"))
    table = Table({"parameters": list(names)}, "calibrate", ())
    plant = HandPlant()
    campaign = Campaign(
        plant, plant, tuple(entries), Path("results"), effects(), "known", calibrate=table
    )
    real = {**dict(Hand().parameters), **made.answer["hand"]}
    true = {name: float(real[name]) for name in names}
    plain = truth.make(protocol, seed, {}, SPREAD).recordings if hidden else {}
    return Case(campaign, true, kind, hidden, fault, stated, protocol, plain)


def _protocol(rng: np.random.Generator) -> Protocol:
    count = int(rng.integers(1, 4))
    chosen = [POOL[k] for k in sorted(rng.choice(len(POOL), count, replace=False))]
    repeats = int(rng.integers(2, 6))
    return Protocol(tuple(replace(each, repeats=repeats) for each in chosen), RICH)


def _asked(rng: np.random.Generator, protocol: Protocol) -> list[str]:
    grasps = any(each.thing is DYNAMOMETER for each in protocol.conditions)
    names = [*ASKED, *(OF_OBJECT if grasps else ())]
    return [str(each) for each in rng.choice(names, int(rng.integers(2, 5)), replace=False)]


def _hidden(rng: np.random.Generator, seed: int) -> dict[str, float]:
    """One effect that the analyst's model lacks; sizes log-uniform."""
    names = amplitudes(CATALOGUE)
    name = names[(seed // 3) % len(names)]
    size, known = SIZES[name], smallest("rich")[name]
    drawn = known[rng.integers(len(known))]
    u = drawn.u or 0.3 * size.high / TIMES[0]
    low, high = (min(each * u, size.high) for each in TIMES)
    amount = float(low * (high / low) ** rng.uniform())
    return {name: amount * (rng.choice([-1.0, 1.0]) if size.low < 0.0 else 1.0), **drawn.shape}


def _unsaid(recording: Recording) -> Recording:
    """As of an analyst whose experiment does not say that his firmware samples."""
    text = recording.experiment.replace('controller = "sampled"\n', "")
    return replace(recording, experiment=text)
