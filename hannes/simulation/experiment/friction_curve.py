"""Friction of joints and guides against speed: equations 1 and 2 alone, as in Fig. 2."""

from dataclasses import dataclass

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.kernels.jit import plain
from hannes.core.recording.recording import Recording
from hannes.dynamics.friction import stribeck
from hannes.simulation.hand.hand import Hand

SAMPLES = 1001
LAWS = {"mcp": "N m", "pip": "N m", "cart": "N"}


@dataclass(frozen=True)
class FrictionCurve:
    """Speeds up to which the joints [rad/s] and the carts [m/s] are swept, both ways."""

    title: str
    hand: Hand
    joint_speed: float
    cart_speed: float

    def __post_init__(self) -> None:
        if not (self.joint_speed > 0.0 and self.cart_speed > 0.0):
            raise BadInput(f"{self.title}: joint_speed and cart_speed must be above zero")

    def recording(self) -> Recording:
        """Speeds and frictions over one second of a steady sweep from -speed to +speed."""
        sweep = np.linspace(-1.0, 1.0, SAMPLES)
        speeds = {"joint_speed": self.joint_speed * sweep, "cart_speed": self.cart_speed * sweep}
        channels = {"time": np.linspace(0.0, 1.0, SAMPLES), **speeds}
        units = {"time": "s", "joint_speed": "rad/s", "cart_speed": "m/s"}
        for part, unit in LAWS.items():
            speed = speeds["cart_speed" if part == "cart" else "joint_speed"]
            channels[f"{part}_friction"] = friction(self.hand, part, speed)
            units[f"{part}_friction"] = unit
        return Recording(channels, units, plant="friction", source="simulated")


def friction(hand: Hand, part: str, speed: np.ndarray) -> np.ndarray:
    """Friction of "mcp", "pip" [N m at rad/s] or "cart" [N at m/s] at each speed, shape (n,)."""
    names = "breakaway_friction", "coulomb_friction", "breakaway_speed", "viscous_friction"
    values = [hand.parameters[f"{part}.{name}"] for name in names]
    return np.array([plain(stribeck)(float(each), *values) for each in speed])
