"""The five fingers in one table: planes, mounts, phalanges, rest and end angles.

Hand frame: x along the palm to the fingertips, y normal to the palm (a grasped object sits at
negative y), z across the fingers. Each finger moves in its own plane z = const. The thumb faces
the others: its in-plane y axis is mirrored.
"""

from hannes.core.parameter import Parameter, group

FINGERS = ("index", "middle", "ring", "little", "thumb")
JOINTS = tuple(f"{finger}_{joint}" for finger in FINGERS for joint in ("mcp", "pip"))

# mm: MCP x, y, z; first, second, third phalanx; g: second, third phalanx
_TABLE = {
    "index": (0, 0, 30, 40, 44, 48, 15, 14),
    "middle": (0, 0, 10, 42, 47, 53, 17, 16),
    "ring": (0, 0, -10, 40, 45, 50, 16, 14),
    "little": (0, 0, -30, 36, 38, 42, 13, 12),
    "thumb": (0, -89, 20, 30, 40, 36, 16, 14),
}
_ANGLES = {  # rad: rest MCP, rest PIP, end MCP, end PIP
    finger: (0.192, 0.242, 1.1, 1.3) if finger == "thumb" else (0.242, 0.292, 1.55, 1.75)
    for finger in FINGERS
}


def _finger(name: str) -> tuple[Parameter, ...]:
    x, y, z, first, second, third, heavy, light = _TABLE[name]
    rest_mcp, rest_pip, end_mcp, end_pip = _ANGLES[name]
    place, size, turn = (-0.3, 0.3), (0.005, 0.2), (-1.0, 3.2)
    return group(
        name,
        Parameter("mount_x", x * 1e-3, "m", place, "MCP joint in the hand frame"),
        Parameter("mount_y", y * 1e-3, "m", place, "MCP joint in the hand frame"),
        Parameter("mount_z", z * 1e-3, "m", place, "plane of the finger in the hand frame"),
        Parameter("facing", -1 if name == "thumb" else 1, "1", (-1, 1), "-1: in-plane y mirrored"),
        Parameter("first_length", first * 1e-3, "m", size, "phalanx fixed to the frame"),
        Parameter("second_length", second * 1e-3, "m", size, "phalanx between MCP and PIP"),
        Parameter("third_length", third * 1e-3, "m", size, "phalanx beyond PIP"),
        Parameter("second_mass", heavy * 1e-3, "kg", (1e-4, 0.5), "phalanx between MCP and PIP"),
        Parameter("third_mass", light * 1e-3, "kg", (1e-4, 0.5), "phalanx beyond PIP"),
        Parameter("radius", 8e-3, "m", (1e-3, 0.03), "of the phalanges' capsules"),
        Parameter("rest_mcp", rest_mcp, "rad", turn, "angle of the open hand"),
        Parameter("rest_pip", rest_pip, "rad", turn, "angle of the open hand"),
        Parameter("end_mcp", end_mcp, "rad", turn, "closing stop"),
        Parameter("end_pip", end_pip, "rad", turn, "closing stop"),
    )


PARAMETERS = tuple(parameter for finger in FINGERS for parameter in _finger(finger)) + group(
    "gravity",
    Parameter("x", 0.0, "m/s2", (-100, 100), "in the hand frame"),
    Parameter("y", 0.0, "m/s2", (-100, 100), "in the hand frame"),
    Parameter("z", -9.81, "m/s2", (-100, 100), "in the hand frame; no torque on planar fingers"),
)

# One compiled array each, over the fingers or the joints.
TABLES: dict[str, tuple[str, ...]] = {
    "mount_x": tuple(f"{finger}.mount_x" for finger in FINGERS),
    "mount_y": tuple(f"{finger}.mount_y" for finger in FINGERS),
    "mount_z": tuple(f"{finger}.mount_z" for finger in FINGERS),
    "facing": tuple(f"{finger}.facing" for finger in FINGERS),
    "phalanx_radius": tuple(f"{finger}.radius" for finger in FINGERS for _ in ("second", "third")),
    "link_length": tuple(
        f"{finger}.{link}_length" for finger in FINGERS for link in ("second", "third")
    ),
    "link_mass": tuple(
        f"{finger}.{link}_mass" for finger in FINGERS for link in ("second", "third")
    ),
    "rest": tuple(f"{finger}.rest_{joint}" for finger in FINGERS for joint in ("mcp", "pip")),
    "end": tuple(f"{finger}.end_{joint}" for finger in FINGERS for joint in ("mcp", "pip")),
}
for _quantity in (
    "moment_arm spring_stiffness spring_preload stop_stiffness stop_damping stop_onset "
    "breakaway_friction coulomb_friction breakaway_speed viscous_friction"
).split():
    TABLES[f"joint_{_quantity}"] = (f"mcp.{_quantity}", f"pip.{_quantity}") * len(FINGERS)
