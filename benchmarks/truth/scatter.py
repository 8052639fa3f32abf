"""No two hands are alike, and no hand runs twice the same."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from benchmarks.truth.parameters import OWN

Draw = Callable[[np.random.Generator, Any], np.ndarray]

# Known exactly (firmware, counts of teeth, calipers) or no property of a hand (regularisations,
# poses).
EXACT = ("position_pid.", "current_pid.", "controller.", "encoder.", "gravity.", "supply.")
EXACT += ("gear.ratio", "motor.friction_speed", "wires.onset", "mcp.stop_onset", "pip.stop_onset")
EXACT += ("object.slip_speed", "object.onset", "object.radius", "object.z")
EXACT += ("object.half_x", "object.half_y")
EXACT += ("fingers.origin_x", "fingers.origin_y", "fingers.plane_z", "fingers.side")
# Places scatter by a share of a length (m), not of their coordinate: 0.2 mm at 2 %.
PLACES = {"object.x": 10e-3, "object.y": 10e-3}
CUT = 2.5  # standard deviations

# What changes from run to run, as shares of the run's scatter: lubrication and temperature move
# friction and damping most, then the springs' seats; winding and supply drift a little.
RUN_TO_RUN = {
    "dry_friction": 1.0,
    "viscous_friction": 1.0,
    "breakaway_friction": 1.0,
    "coulomb_friction": 1.0,
    "damping": 1.0,
    "stop_damping": 1.0,
    "spring_preload": 1.0,
    "friction": 1.0,  # object against finger
    "resistance": 0.6,
    "torque_constant": 0.2,
    "voltage": 0.6,
}
RUN_PLACES = {"object.x": 20e-3, "object.y": 20e-3}  # m: 0.1 mm at 0.5 %


def normal(rng: np.random.Generator, shape: Any) -> np.ndarray:
    """Standard normal, drawn again beyond `CUT`."""
    out = np.atleast_1d(rng.standard_normal(shape))
    while (far := np.abs(out) > CUT).any():
        out[far] = rng.standard_normal(int(far.sum()))
    return out.reshape(shape)


def uniform(rng: np.random.Generator, shape: Any) -> np.ndarray:
    """Between -1 and 1."""
    return rng.uniform(-1.0, 1.0, shape)


LAWS: dict[str, Draw] = {"normal": normal, "uniform": uniform}


def scatter(
    values: Mapping[str, Any], rng: np.random.Generator, spread: float, law: str = "normal"
) -> dict[str, Any]:
    """Another hand: each inexact value times 1 + spread z, finger by finger, and places shifted.

    spread: standard deviation of the normal law, half width of the uniform one (both relative).
    """
    out = dict(values)
    for name in sorted(values):
        z = spread * LAWS[law](rng, np.shape(values[name]))
        if name in PLACES:
            out[name] = float(values[name] + PLACES[name] * z)
        elif not name.startswith(EXACT):
            out[name] = _times(values[name], 1.0 + z)
    return out


def finger_scatter(
    values: Mapping[str, Any], rng: np.random.Generator, spread: float
) -> dict[str, Any]:
    """A hand whose joints differ: each one's arm, spring and friction off for itself (normal)."""
    own = {name: tuple((1.0 + spread * normal(rng, 5)).tolist()) for name in OWN}
    return {**values, **own} if spread > 0.0 else dict(values)


def run_scatter(
    values: Mapping[str, Any], rng: np.random.Generator, spread: float, timing: float
) -> tuple[dict[str, Any], float]:
    """The same hand in another run, and how much later it starts than its clock says (s)."""
    out = dict(values)
    for name in sorted(values):
        z = spread * float(normal(rng, ()))
        if name in RUN_PLACES:
            out[name] = float(values[name] + RUN_PLACES[name] * z)
        elif share := RUN_TO_RUN.get(name.partition(".")[2], 0.0):
            out[name] = float(values[name] * (1.0 + share * z))
    return out, timing * float(normal(rng, ()))


def _times(value: Any, factor: Any) -> Any:
    scaled = np.asarray(value, float) * factor
    return tuple(scaled.tolist()) if scaled.ndim else float(scaled)
