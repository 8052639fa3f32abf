"""No two hands are alike, and no hand runs twice the same."""

from collections.abc import Mapping
from typing import Any

import numpy as np

# Known exactly (firmware, counts of teeth) or no property of a hand (regularisations, poses).
EXACT = (
    "position_pid.",
    "current_pid.",
    "controller.",
    "encoder.",
    "gravity.",
    "supply.",
    "gear.ratio",
    "gear.load_loss",
)
EXACT += ("motor.friction_speed", "wires.onset", "mcp.stop_onset", "pip.stop_onset", "contact.")
EXACT += ("fingers.origin_x", "fingers.origin_y", "fingers.plane_z", "fingers.side")
# What changes from run to run: friction and damping most (1 %), the winding and springs little.
RESTLESS = {"friction": 0.01, "damping": 0.01}
CALM = {"motor.resistance": 0.003, "motor.torque_constant": 0.003}
CALM |= {"mcp.spring_stiffness": 0.003, "pip.spring_stiffness": 0.003}
TIMING = 0.2e-3  # s


def scatter(
    parameters: Mapping[str, Any], rng: np.random.Generator, spread: float = 0.02
) -> dict[str, Any]:
    """Another hand: each inexact value times exp(spread * normal), finger by finger."""
    out = dict(parameters)
    for name in sorted(parameters):
        factor = np.exp(spread * rng.standard_normal(np.shape(parameters[name])))
        if not name.startswith(EXACT):
            out[name] = _times(parameters[name], factor)
    return out


def run_scatter(
    parameters: Mapping[str, Any], rng: np.random.Generator
) -> tuple[dict[str, Any], float]:
    """The same hand in another run, and how much later it starts than its clock says (s)."""
    out = dict(parameters)
    for name in sorted(parameters):
        draw = rng.standard_normal()
        spread = CALM.get(name, RESTLESS.get(name.rpartition("_")[2], 0.0))
        if spread:
            out[name] = float(parameters[name] * np.exp(spread * draw))
    return out, float(TIMING * rng.standard_normal())


def _times(value: Any, factor: Any) -> Any:
    scaled = np.asarray(value, float) * factor
    return tuple(scaled.tolist()) if scaled.ndim else float(scaled)
