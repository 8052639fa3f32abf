"""What the MuJoCo model of `hannes hand --mjcf` gives, and what each law costs that it leaves out.

A free closure of hannes; its motor's angle drives MuJoCo, and motor torque and leader tension are
compared, as RMS in percent of their range. Below, hannes itself without the laws that a parameter
switches off, compared with hannes as it is under the same command.
"""

import math
from dataclasses import replace

import numpy as np

from benchmarks.harness import Row, main, must_show
from hannes import Hand, load_experiment, simulate
from hannes.simulation.trajectory import Trajectory

TURN, BOUND = 0.637, 3.0  # s, when the command turns back; percent
CHANNELS = ("motor torque", "leader tension")


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Rows by what is compared, and the bounds."""
    from benchmarks.mujoco.published import driven

    asked = load_experiment("void-closure")[0]
    experiment = replace(asked.experiment, noise={})
    hand, ran = asked.hand, simulate(asked.hand, experiment)
    ours, theirs = traces(hand, ran), driven(hand, ran.time, ran["motor_angle"])
    closing = ran.time < TURN
    rows = [
        row("MuJoCo, closing", ours, theirs, closing),
        row("MuJoCo, opening: damping of slack wires and stops too", ours, theirs, ~closing),
    ]
    for law, values in switched_off(hand).items():
        changed = hand.with_values(values)
        without = traces(changed, simulate(changed, experiment))
        rows.append(row(f"hannes, {law}", ours, without, closing))
    bounds = [
        must_show(
            f"{name}, RMS % of its range, closing", rows[0][name], BOUND, rows[0][name] <= BOUND
        )
        for name in CHANNELS
    ]
    return rows, bounds


def traces(hand: Hand, ran: Trajectory) -> dict[str, np.ndarray]:
    """Motor torque k_t i [N m] and leader tension [N]."""
    torque = hand.parameters["motor.torque_constant"] * ran["motor_current"]
    return {"motor torque": torque, "leader tension": ran["leader_tension"]}


def row(name: str, ours: dict, theirs: dict, part: np.ndarray) -> Row:
    """RMS differences over part of the samples, in percent of the range over all."""
    found = {
        channel: 100.0
        * float(np.sqrt(np.mean((theirs[channel] - ours[channel])[part] ** 2)))
        / float(np.ptp(ours[channel]))
        for channel in CHANNELS
    }
    return {"compared with hannes": name, **found}


def switched_off(hand: Hand) -> dict[str, dict[str, float]]:
    """Values without one law each, as far as a parameter can switch it off."""
    value = hand.parameters
    straight = {}
    for part in ("mcp", "pip", "cart"):
        level, speed = value[f"{part}.coulomb_friction"], value[f"{part}.breakaway_speed"]
        slope = math.sqrt(math.e) * (value[f"{part}.breakaway_friction"] - level) / speed
        straight[f"{part}.breakaway_friction"] = level
        straight[f"{part}.viscous_friction"] = value[f"{part}.viscous_friction"] + slope
    return {
        "Stribeck peak as viscous friction": straight,
        "Stribeck peak left out": {
            f"{part}.breakaway_friction": value[f"{part}.coulomb_friction"]
            for part in ("mcp", "pip", "cart")
        },
        "full damping from the first touch": {
            "wires.onset": 1e-7, "mcp.stop_onset": 1e-6, "pip.stop_onset": 1e-6,
        },
        "dry friction of the motor a step, of a tenth its width": {
            "motor.friction_speed": 0.1 * value["motor.friction_speed"],
        },
    }  # fmt: skip


if __name__ == "__main__":
    main(__doc__, "mjcf", measure)
