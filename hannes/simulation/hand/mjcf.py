"""The hand as a MuJoCo model (MJCF): what `hannes hand --mjcf` prints.

The mechanics from the rotor to the fingertips, in MuJoCo's own elements: wires are tendons with
springs, joints have springs, dry friction and limits. The motor is driven through its angle, so
winding, drive and controller are left out. What MuJoCo's elements cannot carry of the laws of
the hand stands in `LEFT_OUT`, and at the head of the file.
"""

import math
from collections.abc import Mapping

import numpy as np

from hannes.core.errors import BadInput
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.joint_shares import joint_value
from hannes.simulation.hand.mjcf_bodies import JOINTS, LINKS, skeleton

STEP = 1e-4  # s
IMPEDANCE = 0.9  # of limits and dry friction: MuJoCo's own choice at large violations
RAMP = 1.30  # widths of a tanh over which a straight ramp is nearest to it, in the mean square
SERVO = 1.0  # N m/rad, of the drive through the motor's angle
WIRES = {
    "leader": {"motor": 1.0, "cart_a": -2.0, "cart_b": -2.0, "thumb": -1.0},
    "follower_a": {"cart_a": 2.0, "index": -1.0, "middle": -1.0},
    "follower_b": {"cart_b": 2.0, "ring": -1.0, "little": -1.0},
}
# What is not as in `simulate`, by law. `benchmarks.mjcf` prints what each costs.
LEFT_OUT = {
    "slack wires": "a tendon's damping acts while it is slack too",
    "onset of damping": "wires and stops are damped fully from the first touch",
    "Stribeck peak": "joints and carts have its slope at rest as further viscous friction",
    "smooth dry friction": "rises straight with the speed up to its level, not as its tanh",
    "electrical side": "no winding, drive, controller, sensors: the motor follows an angle",
    "effects": "none of the catalogue",
}


def mjcf(hand: Hand) -> str:
    """The model of a hand as text; BadInput where effects are on, which MuJoCo has no element for.

    Angles in rad, lengths in m, all else SI. Joints are named `motor` (at the motor's side),
    `cart_a`, `cart_b`, `index_mcp`, ...; tendons `leader`, `follower_a`, `follower_b`. Control 0
    is the motor's angle [rad]; sensor `motor_torque` is what the motor gives [N m].
    """
    if present := [each.name for each in hand.present_effects()]:
        raise BadInput(
            f"MuJoCo has no element for {', '.join(present)}: switch off what this hand has beyond "
            "the base model"
        )
    value = hand.parameters
    bodies = skeleton(
        value, lambda name: _joint(value, name), lambda finger, link: _phalanx(value, finger, link)
    )
    gravity = " ".join(f"{value[f'gravity.{axis}']:.6g}" for axis in "xyz")
    damping = 2.0 * math.sqrt(SERVO * value["motor.inertia"])
    wires = "\n    ".join(_wire(value, name) for name in WIRES)
    return f"""<mujoco model="hannes">
  <!--
{_head()}
  -->
  <compiler angle="radian"/>
  <option timestep="{STEP:g}" integrator="implicitfast" cone="elliptic" gravity="{gravity}"/>
  <worldbody>
    {bodies.replace("<body", chr(10) + "    <body")}
  </worldbody>
  <tendon>
    {wires}
  </tendon>
  <actuator>
    <position name="motor" joint="motor" kp="{SERVO:g}" kv="{damping:.6g}"/>
  </actuator>
  <sensor>
    <actuatorfrc name="motor_torque" actuator="motor"/>
    <tendonpos name="leader_length" tendon="leader"/>
    <tendonvel name="leader_speed" tendon="leader"/>
  </sensor>
  <keyframe><key name="rest" qpos="{_rest(value)}"/></keyframe>
</mujoco>
"""


def _head() -> str:
    lines = [
        "The Hannes hand from its motor's rotor to the fingertips, written by hannes.",
        "Start from the keyframe rest; control 0 is the motor's angle [rad, motor side].",
        "Leader tension [N]: stiffness * stretch + damping * rate while stretched, with",
        "stretch = leader_length - the upper springlength of the tendon leader.",
        "Not as in hannes:",
        *(f"  {law}: {words}" for law, words in LEFT_OUT.items()),
    ]
    return "\n".join(f"  {line}" for line in lines)


def _joint(value: Mapping[str, float], name: str) -> str:
    """Friction of every joint; of a finger's also spring and stops."""
    if name == "motor":
        level, width = value["motor.dry_friction"], value["motor.friction_speed"]
        viscous = value["motor.viscous_friction"]
    else:
        level, speed = _of(value, name, "coulomb_friction"), _of(value, name, "breakaway_speed")
        peak = _of(value, name, "breakaway_friction") - level
        viscous = _of(value, name, "viscous_friction") + math.sqrt(math.e) * peak / speed
        width = 0.1 * speed
    text = (
        f'damping="{viscous:.6g}" frictionloss="{level:.6g}" {_constant("solimpfriction")} '
        f'solreffriction="{_soft(value, name, 1.0, level / (RAMP * width))}"'
    )
    return f"{text} {_ends(value, name)}" if name in JOINTS else text


def _of(value: Mapping[str, float], name: str, quantity: str) -> float:
    """A quantity of a finger's joint, or of a cart."""
    return joint_value(value, name, quantity) if name in JOINTS else value[f"cart.{quantity}"]


def _ends(value: Mapping[str, float], name: str) -> str:
    """Spring with preload, and stops, of which the lower carries the preload at rest."""
    finger, kind = name.split("_")
    spring, preload = (joint_value(value, name, f"spring_{x}") for x in ("stiffness", "preload"))
    stop, damping = (joint_value(value, name, f"stop_{x}") for x in ("stiffness", "damping"))
    rest, end = value[f"{finger}.rest_{kind}"], value[f"{finger}.end_{kind}"]
    sagging = f'springref="{rest - preload / spring:.6g}"' if spring > 0.0 else ""
    return (
        f'stiffness="{spring:.6g}" {sagging} limited="true" '
        f'range="{rest + preload / stop:.6g} {end:.6g}" {_constant("solimplimit")} '
        f'solreflimit="{_soft(value, name, stop, damping)}"'
    )


def _phalanx(value: Mapping[str, float], finger: str, link: str) -> str:
    """Capsule of a phalanx: it touches objects, whose bits are MuJoCo's own, but no phalanx."""
    length, radius = value[f"{finger}.{link}_length"], value[f"{finger}.radius"]
    return (
        f'<geom name="{finger}_{link}" type="capsule" fromto="0 0 0 {length:.6g} 0 0" '
        f'size="{radius:.6g}" mass="0" contype="2" conaffinity="1"/>'
    )


def _wire(value: Mapping[str, float], name: str) -> str:
    """A wire: the sum of what its ends take up, with a spring above its length at rest."""
    kind = name.split("_")[0]
    parts: dict[str, float] = {}
    for end, sign in WIRES[name].items():
        for joint, arm in _arms(value, end).items():
            parts[joint] = sign * arm
    free = sum(arm * value[".rest_".join(j.split("_"))] for j, arm in parts.items() if j in JOINTS)
    joints = "".join(f'<joint joint="{joint}" coef="{arm:.9g}"/>' for joint, arm in parts.items())
    return (
        f'<fixed name="{name}" stiffness="{value[f"{kind}.stiffness"]:.6g}" '
        f'damping="{value[f"{kind}.damping"]:.6g}" springlength="{free - 10.0:.9g} {free:.9g}">'
        f"{joints}</fixed>"
    )


def _arms(value: Mapping[str, float], end: str) -> dict[str, float]:
    """Wire taken up per unit of each joint at one end of a wire [m/rad, m/m]."""
    if end == "motor":
        return {"motor": value["gear.pulley_radius"] / value["gear.ratio"]}
    if end.startswith("cart"):
        return {end: 1.0}
    joints = (f"{end}_{kind}" for kind in LINKS)
    return {joint: joint_value(value, joint, "moment_arm") for joint in joints}


def _constant(attribute: str) -> str:
    """An impedance that is the same at any depth."""
    return f'{attribute}="{IMPEDANCE} {IMPEDANCE} 0.001 0.5 2"'


def _soft(value: Mapping[str, float], name: str, stiffness: float, damping: float) -> str:
    """Stiffness [N/m, N m/rad] and damping of a constraint in MuJoCo's direct form.

    MuJoCo counts both per inverse inertia of the joint at zero angles, less what the impedance
    leaves to the motion.
    """
    scale = (1.0 - IMPEDANCE) * inverse_inertia(value, name)
    return f"{-stiffness * scale:.9g} {-damping * scale:.9g}"


def inverse_inertia(value: Mapping[str, float], name: str) -> float:
    """Acceleration of a joint by a unit force there, every other joint free, at zero angles."""
    if name == "motor":
        return 1.0 / value["motor.inertia"]
    if name not in JOINTS:
        return 1.0 / value["cart.mass"]
    finger, kind = name.split("_")
    long, light = value[f"{finger}.second_length"], value[f"{finger}.third_mass"]
    second = value[f"{finger}.third_length"]
    coupling = 0.5 * light * long * second
    tip = light * second**2 / 3.0
    base = value[f"{finger}.second_mass"] * long**2 / 3.0 + light * long**2
    matrix = np.array([[base + tip + 2.0 * coupling, tip + coupling], [tip + coupling, tip]])
    place = list(LINKS).index(kind)
    return float(np.linalg.inv(matrix)[place, place])


def _rest(value: Mapping[str, float]) -> str:
    """Positions of all joints of the open hand."""
    angles = [value[".rest_".join(name.split("_"))] for name in JOINTS]
    return " ".join(f"{x:.9g}" for x in (0.0, 0.0, 0.0, *angles))
