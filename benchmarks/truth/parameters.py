"""Parameters of the second hand: nominal values (SI) and those of a user's hand.toml.

Only N = 19, 12 V and Table I's orders of magnitude are published; all else is a choice.
"""

import difflib
import tomllib
from collections.abc import Mapping
from typing import Any

import numpy as np

# Order everywhere: index, middle, ring, little, thumb. The thumb's plane is mirrored in y (side).
NOMINAL: dict[str, Any] = {
    "motor.torque_constant": 18.08e-3,  # N m/A, and V s/rad
    "motor.resistance": 3.084,
    "motor.inductance": 140e-6,  # L/R about 45 us
    "motor.inertia": 3.31e-7,
    "motor.dry_friction": 4.7e-3,
    "motor.friction_speed": 5.0,
    "motor.viscous_friction": 5.25e-7,
    "gear.ratio": 19.0,
    "gear.pulley_radius": 4.74e-3,
    "leader.stiffness": 6.7e4,
    "leader.damping": 30.0,
    "follower.stiffness": 6.45e4,
    "follower.damping": 20.0,
    "wires.onset": 20e-6,
    "cart.mass": 10e-3,
    "cart.breakaway_friction": 2e-2,
    "cart.coulomb_friction": 1e-2,
    "cart.breakaway_speed": 10e-3,
    "cart.viscous_friction": 1.0,
    "mcp.breakaway_friction": 13.9e-3,
    "mcp.coulomb_friction": 10.7e-3,
    "mcp.breakaway_speed": 100 * np.pi / 30,
    "mcp.viscous_friction": 1.07e-3,
    "mcp.moment_arm": 10e-3,
    "mcp.spring_stiffness": 24.7e-3,
    "mcp.spring_preload": 27.7e-3,
    "mcp.stop_stiffness": 6.0,
    "mcp.stop_damping": 0.02,
    "pip.breakaway_friction": 10.7e-3,
    "pip.coulomb_friction": 2.1e-3,
    "pip.breakaway_speed": 100 * np.pi / 30,
    "pip.viscous_friction": 1.07e-3,
    "pip.moment_arm": 4.5e-3,
    "pip.spring_stiffness": 22.2e-3,
    "pip.spring_preload": 9.3e-3,
    "pip.stop_stiffness": 6.0,
    "pip.stop_damping": 0.02,
    "mcp.stop_onset": 1e-3,  # rad of penetration over which a stop's damping sets in
    "pip.stop_onset": 1e-3,
    "fingers.proximal_length": (44e-3, 47e-3, 45e-3, 38e-3, 40e-3),
    "fingers.distal_length": (48e-3, 53e-3, 50e-3, 42e-3, 36e-3),
    "fingers.proximal_mass": (15e-3, 17e-3, 16e-3, 13e-3, 16e-3),
    "fingers.distal_mass": (14e-3, 16e-3, 14e-3, 12e-3, 14e-3),
    "fingers.radius": (8e-3, 8e-3, 8e-3, 8e-3, 8e-3),
    "fingers.mcp_rest": (0.242, 0.242, 0.242, 0.242, 0.192),
    "fingers.pip_rest": (0.292, 0.292, 0.292, 0.292, 0.242),
    "fingers.mcp_upper": (1.55, 1.55, 1.55, 1.55, 1.1),
    "fingers.pip_upper": (1.75, 1.75, 1.75, 1.75, 1.3),
    "fingers.origin_x": (0.0, 0.0, 0.0, 0.0, 0.0),
    "fingers.origin_y": (0.0, 0.0, 0.0, 0.0, -89e-3),
    "fingers.plane_z": (30e-3, 10e-3, -10e-3, -30e-3, 20e-3),
    "fingers.side": (1.0, 1.0, 1.0, 1.0, -1.0),
    "gravity.x": 0.0,  # m/s2 in the hand frame; off unless asked for
    "gravity.y": 0.0,
    "object.stiffness": 38300.0,  # the dynamometer's, unless an experiment gives another object
    "object.damping": 184.0,
    "object.friction": 0.55,
    "object.slip_speed": 5e-3,
    "object.onset": 1e-4,
    "object.radius": 26e-3,  # of a prism's edges
    "object.half_x": 0.0,  # of a prism
    "object.half_y": 0.0,
    "object.x": 14.6e-3,
    "object.y": -46.9e-3,
    "object.z": 0.0,
    "supply.voltage": 12.0,
    "position_pid.proportional": 0.0358,  # A/rad, motor side
    "position_pid.integral": 0.0,  # A/(rad s)
    "position_pid.derivative": 1.95e-3,  # A s/rad
    "position_pid.filter": 2.5e-3,  # s, continuous controller
    "controller.speed_weight": 0.4,  # sampled controller's one-pole filter
    "position_pid.limit": 4.0,
    "current_pid.proportional": 1.0,  # V/A
    "current_pid.integral": 900.0,  # V/(A s)
    "controller.period": 1e-3,
    "controller.current_step": 0.0,  # A, resolution of the sampled current; 0: none
    "encoder.bits": 12.0,  # per turn of the output shaft, multi-turn
}


# Factors of one finger's own value to that which all share; 1 in the nominal hand.
OWN = tuple(
    f"finger_share.{joint}_{what}"
    for joint in ("mcp", "pip")
    for what in (
        "moment_arm",
        "spring_stiffness",
        "spring_preload",
        "breakaway_friction",
        "coulomb_friction",
        "viscous_friction",
    )
)
# What a hand.toml calls each finger's values.
FINGERS = ("index", "middle", "ring", "little", "thumb")
GEOMETRY = {
    "second_length": "fingers.proximal_length",
    "third_length": "fingers.distal_length",
    "second_mass": "fingers.proximal_mass",
    "third_mass": "fingers.distal_mass",
    "radius": "fingers.radius",
    "rest_mcp": "fingers.mcp_rest",
    "rest_pip": "fingers.pip_rest",
    "end_mcp": "fingers.mcp_upper",
    "end_pip": "fingers.pip_upper",
    "mount_x": "fingers.origin_x",
    "mount_y": "fingers.origin_y",
    "mount_z": "fingers.plane_z",
    "facing": "fingers.side",
}
# Without a part in this hand: fixed phalanges, gravity across the finger planes, sampling
# (chosen per simulation), the filter of an absent derivative.
UNUSED = ("gravity.z", "controller.sampled", "current_pid.filter")
UNUSED += tuple(f"{finger}.first_length" for finger in FINGERS)
# What this hand has at no other value.
ABSENT = {("current_pid.derivative", 0.0)}
ABSENT |= {(f"{f}.{joint}_stop_stiffness", 1.0) for f in FINGERS for joint in ("mcp", "pip")}


def nominal() -> dict[str, Any]:
    """A copy of the nominal values (SI)."""
    return dict(NOMINAL)


def named(values: Mapping[str, Any]) -> dict[str, Any]:
    """The nominal values with `values` (SI, by the names of NOMINAL or of a hand.toml) in place.

    Raises ValueError with the nearest match for a name that neither knows.
    """
    out = dict(NOMINAL)
    for name, value in values.items():
        part, _, what = name.partition(".")
        if name in NOMINAL or name in OWN:
            out[name] = value
        elif part in FINGERS and what in GEOMETRY:
            row = list(out[GEOMETRY[what]])
            row[FINGERS.index(part)] = float(value)
            out[GEOMETRY[what]] = tuple(row)
        elif part in FINGERS and f"finger_share.{what}" in OWN:
            row = list(out.get(f"finger_share.{what}", (1.0,) * len(FINGERS)))
            row[FINGERS.index(part)] = float(value)
            out[f"finger_share.{what}"] = tuple(row)
        elif not (name.startswith(UNUSED) or (name, value) in ABSENT):
            raise ValueError(_stranger(name))
    return out


def flat(values: Mapping[str, Any]) -> dict[str, float]:
    """All values under the names of a hand.toml, one number each."""
    out: dict[str, float] = {}
    for name, value in values.items():
        if name.startswith("fingers."):
            what = next(key for key, home in GEOMETRY.items() if home == name)
            out |= {f"{f}.{what}": float(x) for f, x in zip(FINGERS, value, strict=True)}
        elif name in OWN:
            out |= {f"{name}.{f}": float(x) for f, x in zip(FINGERS, value, strict=True)}
        else:
            out[name] = float(value)
    return out


def _stranger(name: str) -> str:
    known = [*NOMINAL, *(f"{finger}.{what}" for finger in FINGERS for what in GEOMETRY)]
    near = difflib.get_close_matches(name, known, n=1)
    return f"no parameter of this hand is called {name}" + (f"; meant {near[0]}?" if near else "")


def to_si(value: Any, unit: str | None = None) -> Any:
    """'3.1 mm' -> 0.0031; a list by item; a bare number stays. `unit`: refuse other dimensions."""
    import pint

    if isinstance(value, list):
        return tuple(to_si(item, unit) for item in value)
    if isinstance(value, int | float):
        return float(value)
    try:
        quantity = pint.get_application_registry().Quantity(value).to_base_units()
        number = float(quantity.to(unit).magnitude if unit else quantity.magnitude)
    except pint.PintError as error:
        raise ValueError(f"expected a value with unit such as '3 {unit}': {error}") from None
    if not np.isfinite(number):
        raise ValueError(f"expected a finite value, came {value}")
    return number


def parse_hand(text: str) -> dict[str, Any]:
    """The nominal values with those of a hand.toml's `[parameters]` in their place."""
    table = tomllib.loads(text).get("parameters", {})
    return named({name: to_si(value) for name, value in table.items()})
