"""Parameters of the second hand: nominal values (SI) and those of a user's hand.toml.

Only N = 19, 12 V and Table I's orders of magnitude are published; all else is a choice.
"""

import difflib
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

# Order everywhere: index, middle, ring, little, thumb. The thumb's plane is mirrored in y (side).
NOMINAL: dict[str, Any] = {
    "motor.torque_constant": 19.35e-3,  # N m/A, and V s/rad
    "motor.resistance": 3.084,
    "motor.inductance": 139e-6,  # L/R about 45 us
    "motor.inertia": 3.31e-7,
    "motor.dry_friction": 4.47e-3,
    "motor.friction_speed": 5.0,
    "motor.viscous_friction": 1e-6,
    "gear.ratio": 19.0,
    "gear.load_loss": 0.0,
    "gear.pulley_radius": 4.83e-3,
    "leader.stiffness": 6e4,
    "leader.damping": 30.0,
    "follower.stiffness": 6e4,
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
    "mcp.spring_preload": 24.7e-3,
    "mcp.stop_stiffness": 6.0,
    "mcp.stop_damping": 0.02,
    "pip.breakaway_friction": 10.7e-3,
    "pip.coulomb_friction": 2.1e-3,
    "pip.breakaway_speed": 100 * np.pi / 30,
    "pip.viscous_friction": 1.07e-3,
    "pip.moment_arm": 4.5e-3,
    "pip.spring_stiffness": 19.7e-3,
    "pip.spring_preload": 19.7e-3,
    "pip.stop_stiffness": 6.0,
    "pip.stop_damping": 0.02,
    "stops.onset": 1e-3,  # rad of penetration over which a stop's damping sets in
    "fingers.proximal_length": (44e-3, 47e-3, 45e-3, 38e-3, 40e-3),
    "fingers.distal_length": (48e-3, 53e-3, 50e-3, 42e-3, 36e-3),
    # 12 g at 36 mm to 17 g at 53 mm
    "fingers.proximal_mass": (14.353e-3, 15.235e-3, 14.647e-3, 12.588e-3, 13.176e-3),
    "fingers.distal_mass": (15.529e-3, 17e-3, 16.118e-3, 13.765e-3, 12e-3),
    "fingers.radius": (8e-3, 8e-3, 8e-3, 8e-3, 8e-3),
    "fingers.mcp_rest": (0.242, 0.242, 0.242, 0.242, 0.192),
    "fingers.pip_rest": (0.292, 0.292, 0.292, 0.292, 0.242),
    "fingers.mcp_upper": (1.55, 1.55, 1.55, 1.55, 1.1),
    "fingers.pip_upper": (1.75, 1.75, 1.75, 1.75, 1.3),
    "fingers.origin_y": (0.0, 0.0, 0.0, 0.0, -89e-3),
    "fingers.plane_z": (33e-3, 11e-3, -11e-3, -33e-3, 0.0),
    "fingers.side": (1.0, 1.0, 1.0, 1.0, -1.0),
    "gravity.x": 0.0,  # m/s2 in the hand frame; off unless asked for
    "gravity.y": 0.0,
    "contact.onset": 1e-4,
    "contact.slip_speed": 5e-3,
    "supply.voltage": 12.0,
    "control.position_gain": 0.0472,  # A/rad, motor side
    "control.integral_gain": 0.0,  # A/(rad s)
    "control.velocity_gain": 1.37e-3,  # A s/rad
    "control.reference_share": 0.0,  # of the reference's speed in the velocity term
    "control.speed_lag": 2.5e-3,  # s, continuous controller
    "control.speed_weight": 0.4,  # sampled controller's one-pole filter
    "control.current_limit": 4.0,
    "control.current_gain": 1.0,  # V/A
    "control.current_integral_gain": 900.0,  # V/(A s)
    "control.period": 1e-3,
    "encoder.counts": 4096.0,  # per turn of the output shaft, multi-turn
}


def nominal() -> dict[str, Any]:
    """A copy of the nominal values (SI)."""
    return dict(NOMINAL)


def check_names(names: Any) -> None:
    """ValueError with the nearest match for a name that no parameter has."""
    for name in names:
        if name not in NOMINAL:
            near = difflib.get_close_matches(name, NOMINAL, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise ValueError(f"no parameter is called {name}{hint}")


def to_si(value: Any, unit: str | None = None) -> Any:
    """'3.1 mm' -> 0.0031; a list by item; a bare number stays. `unit`: refuse other dimensions."""
    import pint

    if isinstance(value, list):
        return tuple(to_si(item, unit) for item in value)
    if isinstance(value, int | float):
        return float(value)
    try:
        quantity = pint.get_application_registry().Quantity(value).to_base_units()
        return float(quantity.to(unit).magnitude if unit else quantity.magnitude)
    except pint.PintError as error:
        raise ValueError(f"expected a value with unit such as '3 {unit}': {error}") from None


def read_hand(path: str | Path) -> dict[str, Any]:
    """The nominal values with those of a hand.toml's `[parameters]` in their place."""
    table = tomllib.loads(Path(path).read_text(encoding="utf-8")).get("parameters", {})
    check_names(table)
    return dict(NOMINAL, **{name: to_si(value) for name, value in table.items()})


def fields(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters (any subset; the rest nominal) as floats and float64 arrays of length 5."""
    check_names(parameters)
    merged = {name: parameters.get(name, value) for name, value in NOMINAL.items()}
    out: dict[str, Any] = {}
    for name, value in merged.items():
        key = name.replace(".", "_")
        out[key] = np.array(value, float) if name.startswith("fingers.") else float(value)
    return out
