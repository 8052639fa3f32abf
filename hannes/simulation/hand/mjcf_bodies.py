"""Bodies of the hand in MuJoCo's format (MJCF): rotor, two carts, ten moving phalanges as rods."""

from collections.abc import Callable, Mapping

from hannes.simulation.hand.anatomy import FINGERS

LINKS = {"mcp": "second", "pip": "third"}  # the phalanx that each joint moves
JOINTS = tuple(f"{finger}_{joint}" for finger in FINGERS for joint in LINKS)


def nothing(*names: str) -> str:
    """No further attributes or elements."""
    return ""


def skeleton(
    values: Mapping[str, float],
    joint: Callable[..., str] = nothing,
    phalanx: Callable[..., str] = nothing,
) -> str:
    """All bodies, in the order motor, cart_a, cart_b, `JOINTS`.

    `joint(name)` adds attributes to a joint, `phalanx(finger, link)` elements to its body.
    """
    turning = values["motor.inertia"]
    bodies = [_body("motor", "hinge", "0 0 1", joint, 1e-3, (turning,) * 3)]
    bodies += [
        _body(name, "slide", "1 0 0", joint, values["cart.mass"], (1e-6,) * 3)
        for name in ("cart_a", "cart_b")
    ]
    return "".join(bodies + [_finger(values, finger, joint, phalanx) for finger in FINGERS])


def _finger(values, finger, joint, phalanx):
    inside = ""
    for kind, link in reversed(LINKS.items()):
        length, mass = values[f"{finger}.{link}_length"], values[f"{finger}.{link}_mass"]
        turning, axis = mass * length**2 / 12.0, f"0 0 {-values[f'{finger}.facing']}"
        start = f"{values[f'{finger}.second_length']} 0 0"
        if kind == "mcp":
            start = " ".join(str(values[f"{finger}.mount_{x}"]) for x in "xyz")
        inside = _body(
            *(f"{finger}_{kind}", "hinge", axis, joint, mass, (1e-15, turning, turning)),
            *(start, f"{length / 2} 0 0", phalanx(finger, link) + inside),
        )
    return inside


def _body(name, kind, axis, joint, mass, turning, start="0 0 0", centre="0 0 0", inside=""):
    return (
        f'<body name="{name}" pos="{start}">'
        f'<joint name="{name}" type="{kind}" axis="{axis}" {joint(name)}/>'
        f'<inertial pos="{centre}" mass="{mass}" diaginertia="{" ".join(map(str, turning))}"/>'
        f"{inside}</body>"
    )
