"""What each joint has for itself: its share of the value that all MCP or all PIP joints have.

Fingers are made alike and are not alike. A share is 1 unless a hand's file says otherwise in a
`[[finger]]` table, and a joint's value is the shared one times its share.
"""

from collections.abc import Mapping

from hannes.core.parameter import Parameter
from hannes.simulation.hand.anatomy import FINGERS

# Quantity of a joint -> bounds of its share. A wire off its pulley has no arm, a lost spring
# neither stiffness nor preload.
QUANTITIES = {
    "moment_arm": (0.0, 4.0),
    "spring_stiffness": (0.0, 4.0),
    "spring_preload": (0.0, 4.0),
    "breakaway_friction": (0.0, 100.0),
    "coulomb_friction": (0.0, 100.0),
    "viscous_friction": (0.0, 100.0),
    "stop_stiffness": (0.01, 100.0),
}
KINDS = ("mcp", "pip")


def _share(finger: str, kind: str, quantity: str, bounds: tuple[float, float]) -> Parameter:
    shared = f"{kind}.{quantity}"
    doc = f"share of {shared} that this finger's joint has"
    return Parameter(f"{finger}.{kind}_{quantity}", 1.0, "1", bounds, doc, shared=shared)


PARAMETERS = tuple(
    _share(finger, kind, quantity, bounds)
    for finger in FINGERS
    for kind in KINDS
    for quantity, bounds in QUANTITIES.items()
)
# Share of each entry of a compiled table of joints.
BY_TABLE = {
    f"joint_{quantity}": tuple(
        f"{finger}.{kind}_{quantity}" for finger in FINGERS for kind in KINDS
    )
    for quantity in QUANTITIES
}


def joint_value(values: Mapping[str, float], joint: str, quantity: str) -> float:
    """A quantity [SI] of one joint such as index_mcp, its share included."""
    finger, kind = joint.split("_")
    shared = values[f"{kind}.{quantity}"]
    return shared * values[f"{finger}.{kind}_{quantity}"] if quantity in QUANTITIES else shared
