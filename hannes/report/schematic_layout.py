"""Where the schematic has the parts of the hand, and which effect sits at which part."""

import math
from typing import Any

from hannes.core.effect import Effect
from hannes.plants.part_fault import PartFault
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.model import EQUATIONS

WIDTH, HEIGHT = 900, 470
SCALE = 1900.0  # drawn units per metre, of phalanges and moment arms
TRAVEL = 2600.0  # drawn units per metre that a cart goes
ROWS = {"index": 50, "middle": 130, "ring": 220, "little": 300, "thumb": 400}
CARTS = {"a": 96, "b": 266}  # height of each cart
FOLLOWERS = {"a": ("index", "middle"), "b": ("ring", "little")}
MOTOR, RETURN, CART, FINGER = 60, 130, 290, 500  # from the left
WHEEL, SMALL = 17, 12  # radius of a cart's pulleys, and of those that stand

# The part where an effect sits: by a channel that it adds to, else by that channel's stage.
CHANNELS = dict.fromkeys(("follower_compliance", "follower_loss", "tendon_tension"), "follower")
STAGES = {
    **dict.fromkeys(("position_reference", "probe", "sense", "control", "sample"), "controller"),
    **{"drive": "motor", "gear": "gear", "leader": "leader", "carts": "cart", "joints": "joint"},
    **dict.fromkeys(("contact", "press", "sense_forces"), "object"),
}
# Parameters of each part, by what their names begin with.
PARAMETERS = {
    "controller": ("position_pid", "current_pid", "controller", "encoder", "supply"),
    "motor": ("motor",),
    "gear": ("gear",),
    "leader": ("leader", "wires"),
    "follower": ("follower", "wires"),
    "cart": ("cart",),
    "mcp": ("mcp",),
    "pip": ("pip",),
    "object": ("object",),
    **{finger: (finger,) for finger in FINGERS},
}


def parts_of(effect: Effect) -> tuple[str, ...]:
    """Parts of the drawing at which an effect sits, from the channels that it adds to."""
    found: dict[str, None] = {}
    for term in effect.terms:
        for channel in term.writes:
            part = CHANNELS.get(channel) or STAGES.get(EQUATIONS.stage_of(channel), "")
            if part:
                found[part] = None
    if isinstance(effect, PartFault):
        moved = {name.partition(".")[0] for each in effect.moves.values() for name in each}
        found |= dict.fromkeys(part for part, kinds in PARAMETERS.items() if moved & {*kinds})
    return tuple(found)


def layout() -> dict[str, Any]:
    """Where what is, for whoever moves it [drawn units].

    `wires`: routes from end to end as [x, y, cart], cart "" where the point stands. `travel`:
    units that a cart goes towards the motor per metre.
    """
    return {
        "width": WIDTH,
        "height": HEIGHT,
        "travel": TRAVEL,
        "scale": SCALE,
        "wheel": WHEEL,
        "motor": [MOTOR, CARTS["a"]],
        "carts": {name: [CART, y] for name, y in CARTS.items()},
        "fingers": {finger: [FINGER, y] for finger, y in ROWS.items()},
        "wires": {"leader": leader(), **{f"follower_{cart}": follower(cart) for cart in CARTS}},
    }


def leader() -> list[list[Any]]:
    """Motor, around cart A, two fixed pulleys, around cart B, two more, to the thumb."""
    a, b, low = CARTS["a"], CARTS["b"], ROWS["thumb"] + flexor()
    return [
        [MOTOR, a - WHEEL, ""],
        *([x, y, "a"] for x, y in _arc(CART - 32, a, WHEEL, -90, 90)),
        *([x, y, ""] for x, y in _turn(RETURN, a + WHEEL, b - WHEEL)),
        *([x, y, "b"] for x, y in _arc(CART - 32, b, WHEEL, -90, 90)),
        *([x, y, ""] for x, y in _turn(RETURN, b + WHEEL, low)),
        [FINGER, low, ""],
    ]


def follower(cart: str) -> list[list[Any]]:
    """From one finger around the cart's second pulley to the other."""
    first, second = (ROWS[finger] + flexor() for finger in FOLLOWERS[cart])
    y, aside = CARTS[cart], FINGER - 70
    return [
        [FINGER, first, ""],
        [aside, first, ""],
        *([x, w, cart] for x, w in _arc(CART + 32, y, WHEEL, -90, -270)),
        [aside, second, ""],
        [FINGER, second, ""],
    ]


def flexor() -> float:
    """How far below a finger's axis its wire is drawn at the base."""
    return 19.0


def guides() -> list[tuple[float, float]]:
    """Centres of the pulleys that stand."""
    a, b, low = CARTS["a"], CARTS["b"], ROWS["thumb"] + flexor()
    heights = (a + WHEEL + SMALL, b - WHEEL - SMALL, b + WHEEL + SMALL, low - SMALL)
    return [(RETURN, y) for y in heights]


def _arc(x: float, y: float, radius: float, start: float, end: float) -> list[tuple[float, float]]:
    """Points along an arc about (x, y); degrees, clockwise from the right."""
    angles = [math.radians(start + (end - start) * k / 8) for k in range(9)]
    return [
        (round(x + radius * math.cos(a), 1), round(y + radius * math.sin(a), 1)) for a in angles
    ]


def _turn(x: float, top: float, bottom: float) -> list[tuple[float, float]]:
    """Around two small pulleys, one under the other, from the one's top to the other's bottom."""
    upper = _arc(x, top + SMALL, SMALL, -90, -180)
    return upper + _arc(x, bottom - SMALL, SMALL, 180, 90)
