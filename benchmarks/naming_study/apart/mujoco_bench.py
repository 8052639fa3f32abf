"""Recordings of a hand in MuJoCo's own laws of contact, wires and dry friction.

Hands scatter and differ from run to run as those of the truth do, each joint 1 % off for itself.
The controller is the continuous one, as the experiments say. Slack is a leader that is longer than
its path; load is dry friction (`frictionloss`) of the motor that grows with the motor's torque.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.guarding.plan import SPREAD
from benchmarks.truth import bench
from benchmarks.truth.campaign import RUN, SENSORS, SHIPPED, Made, real_hand
from benchmarks.truth.noise import current_noise
from benchmarks.truth.parameters import flat, parse_hand
from benchmarks.truth.protocol import PAPER, Condition, Protocol
from benchmarks.truth.scatter import run_scatter
from hannes import Hand, Recording
from hannes.simulation.experiment.experiment import Experiment, Reference, Target

RUNS = 6
POOR = ("reference_rad", "position_rad", "current_A")
PLAN = Protocol(
    (
        Condition("void", PAPER, RUNS),
        Condition("dynamometer", PAPER, RUNS, {"shape": "cylinder"}, also=("force_N",)),
    ),
    POOR,
)
IMPEDANCE, INTEGRATOR, STEPS = 0.7, "implicitfast", 8  # of MuJoCo; steps between two samples
TICKS = 2.0**12  # of the encoder, a turn of the output shaft


def make(seed: int, hidden: Mapping[str, float]) -> Made:
    """A campaign in memory; hidden: leader_slack.length [m], gear_load.coefficient, or neither."""
    values, _ = real_hand(parse_hand(SHIPPED), seed, SPREAD)
    made = Made({}, {}, SHIPPED, {"hand": flat(values)}, SPREAD)
    for k, condition in enumerate(PLAN.runs):
        name = f"{k + 1:02d}_{condition.stem}"
        run = _run(values, condition, hidden, np.random.default_rng([seed, RUN, k]))
        made.recordings[name] = _logged(run, condition, np.random.default_rng([seed, SENSORS, k]))
        made.conditions[name] = condition.name
    return made


def library_names(values: Mapping[str, Any]) -> dict[str, float]:
    """A hand's values as its file has them."""
    found = {}
    for name, value in flat(values).items():
        part, _, rest = name.partition(".")
        what, _, finger = rest.partition(".")
        found[f"{finger}.{what}" if part == "finger_share" else name] = value
    return found


def _run(
    hand: Mapping[str, Any],
    condition: Condition,
    hidden: Mapping[str, float],
    rng: np.random.Generator,
) -> dict[str, np.ndarray]:
    from benchmarks.mujoco import native
    from benchmarks.mujoco.elements import Idiom

    values, late = run_scatter(hand, rng, SPREAD.run, SPREAD.timing)
    times, angles = np.array(condition.points).T
    target = Target("cylinder") if condition.thing else None
    reference = Reference([times + late, angles])
    experiment = Experiment(condition.name, condition.duration, reference, target)
    own = Hand().with_values(library_names(values))
    idiom = Idiom(IMPEDANCE, False, hidden.get("leader_slack.length", 0.0))
    load = hidden.get("gear_load.coefficient", 0.0)
    run = native.launch(own, experiment, idiom, INTEGRATOR, STEPS, load)
    found = native.traces(run, own)
    shaft = found["motor_angle"] / own.parameters["gear.ratio"]
    step = 2.0 * np.pi / TICKS
    ticks = np.arange(shaft.size) / experiment.sampling
    current = found["current"] + current_noise(rng, shaft.size)
    return {
        "time_s": ticks,
        "reference_rad": np.interp(ticks, times, angles),
        "position_rad": step * np.round(shaft / step),
        "current_A": bench.CURRENT_STEP * np.round(current / bench.CURRENT_STEP),
        "force_N": found["force"],
    }


def _logged(
    run: Mapping[str, np.ndarray], condition: Condition, rng: np.random.Generator
) -> Recording:
    found = bench.logged(run, condition, POOR, SHIPPED, rng)
    text = found.experiment.replace('controller = "sampled"', 'controller = "continuous"')
    return Recording(found.channels, found.units, "hand", text, SHIPPED)
