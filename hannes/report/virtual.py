"""Hands that do not exist: the shipped one with its inexact values scattered.

They stand where the paper has four real hands, whose recordings are not published.
"""

import numpy as np

from hannes.hand import Hand

COUNT = 4
SEED = 2
SPREAD = 0.03  # standard deviation of the logarithm of every inexact value
DRY_FRICTION_SPREAD = 0.10  # idem, of motor and gear, which sets the void current: a choice

# Known exactly (counts, firmware), a regularisation, or no property of the hand.
EXACT = ("position_pid.", "current_pid.", "controller.", "encoder.", "supply.", "gravity.")
EXACT += ("object.", "gear.ratio", "motor.friction_speed")
_POSES = ("mount_x", "mount_y", "mount_z", "facing", "onset", "rest_mcp", "rest_pip")


def scattered(hand: Hand, seed: int, spread: float = SPREAD) -> Hand:
    """Return another hand: each inexact value times exp(spread x normal), one draw for each."""
    rng = np.random.default_rng(seed)
    changed = {}
    for name, value in hand.parameters.items():
        width = DRY_FRICTION_SPREAD if name == "motor.dry_friction" else spread
        factor = float(np.exp(width * rng.standard_normal()))
        if not name.startswith(EXACT) and not name.endswith(_POSES):
            changed[name] = value * factor
    return hand.with_values(changed)


def hands(base: Hand) -> list[Hand]:
    """Return the virtual hands of Fig. 7."""
    return [scattered(base, SEED * 100 + k) for k in range(COUNT)]
