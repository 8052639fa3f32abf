"""The hand written in MuJoCo's own elements: the nearest thing to it that MuJoCo has.

- wires: fixed tendons, one-sided springs with damping, or limits (`Idiom.limits`)
- joints: native springs, viscous damping, `frictionloss` and limits; carts likewise
- contact: capsules against the object, elliptic cones; the cylinder is a long capsule, which is
  the same surface here and collides twice as fast
- motor: `dcmotor` with winding inductance, fed with a voltage

MuJoCo's contacts, limits and dry friction are soft constraints with an inertia of their own:
d/(1-d) of what they act on, d the impedance. Stiffness and damping are ours (solref in its
direct form, scaled by MuJoCo's own inverse weights). What it does not have: the peak of friction
at breakaway, and a smooth onset of damping. Impedance 0.7 and GRIP were chosen, of 0.2 to 0.95
and 20 to 40 N, for the least worst difference to our converged traces.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco

from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.joint_shares import joint_value
from hannes.simulation.hand.mjcf_bodies import JOINTS, LINKS, skeleton

STATES = 4  # of the controller
GRIP = 20.0  # N, of normal force at which friction rises with slip as steeply as ours
WAYS = {
    "leader": {"motor": 1.0, "cart_a": -2.0, "cart_b": -2.0, "thumb": -1.0},
    "follower_a": {"cart_a": 2.0, "index": -1.0, "middle": -1.0},
    "follower_b": {"cart_b": 2.0, "ring": -1.0, "little": -1.0},
}


@dataclass(frozen=True)
class Idiom:
    """Choices that MuJoCo leaves open: impedance of all constraints; wires as limits or springs.

    loose: length [m] by which the leader is longer than the hand's own
    """

    impedance: float
    limits: bool
    loose: float = 0.0

    def __str__(self) -> str:
        return "limits" if self.limits else "springs"


class Writer:
    """Writes the model of one hand; `weights` are MuJoCo's inverse inertias by element name.

    grasps: whether there is an object
    """

    def __init__(
        self, hand: Hand, idiom: Idiom, userdata: int, weights: Mapping[str, float], grasps: bool
    ) -> None:
        self.value, self.idiom, self.grasps = hand.parameters, idiom, grasps
        self.userdata, self.weights = userdata, weights
        self.arms = {
            "motor": {"motor": self.value["gear.pulley_radius"] / self.value["gear.ratio"]},
            **{cart: {cart: 1.0} for cart in ("cart_a", "cart_b")},
            **{f: {f"{f}_{j}": self.own(f"{f}_{j}", "moment_arm") for j in LINKS} for f in FINGERS},
        }

    def own(self, joint: str, quantity: str) -> float:
        """What a finger's joint has for itself."""
        return joint_value(self.value, joint, quantity)

    def text(self, integrator: str) -> str:
        """The whole model; sensors are compiled in and switched off."""
        value, k = self.value, self.value["motor.torque_constant"]
        place = " ".join(str(value[f"object.{x}"]) for x in "xyz")
        wires = "".join(self.wire(name) for name in WAYS)
        touching = FINGERS if self.grasps else ()
        pairs = "".join(self.pair(f"{f}_{link}") for f in touching for link in LINKS.values())
        return f"""
            <mujoco><compiler angle="radian"/><size nuserdata="{self.userdata}"/>
            <option integrator="{integrator}" cone="elliptic"><flag gravity="disable"
            sensor="disable" island="disable" autoreset="disable"/></option>
            <worldbody>{skeleton(value, self.joint, self.phalanx)}
            <body pos="{place}"><geom name="object" type="capsule" contype="0" conaffinity="0"
            size="{value["object.radius"]} 0.2"/><site name="object" size="1"/></body></worldbody>
            <contact>{pairs}</contact><tendon>{wires}</tendon>
            <actuator><dcmotor name="motor" joint="motor" motorconst="{k} {k}"
            resistance="{value["motor.resistance"]}" inductance="{value["motor.inductance"]} 0"/>
            <general name="control" joint="motor" dyntype="user" actdim="{STATES}" gainprm="0"
            biastype="none"/></actuator>
            <sensor><touch site="object"/><tendonpos tendon="leader"/>
            <tendonvel tendon="leader"/></sensor></mujoco>"""

    def soft(self, name: str, stiffness: float, damping: float) -> str:
        """Stiffness [N/m, N m/rad] and damping of a constraint in MuJoCo's direct form."""
        scale = (1.0 - self.idiom.impedance) * self.weights.get(name, 1.0)
        return f"{-stiffness * scale} {-damping * scale}"

    @property
    def impedance(self) -> str:
        """The same at any depth."""
        return f"{self.idiom.impedance} {self.idiom.impedance} 0.001 0.5 2"

    def joint(self, name: str) -> str:
        """Friction of every joint; spring and stops of a finger's."""
        if name == "motor":
            level, width = (self.value[f"motor.{x}"] for x in ("dry_friction", "friction_speed"))
            viscous = self.value["motor.viscous_friction"]
        elif name in JOINTS:
            level = self.own(name, "coulomb_friction")
            width = 0.1 * self.own(name, "breakaway_speed")
            viscous = self.own(name, "viscous_friction")
        else:
            level = self.value["cart.coulomb_friction"]
            width = 0.1 * self.value["cart.breakaway_speed"]
            viscous = self.value["cart.viscous_friction"]
        text = f'damping="{viscous}" frictionloss="{level}" solimpfriction="{self.impedance}" '
        text += f'solreffriction="{self.soft(name, 1.0, level / width)}" '
        return text + (self.ends(name) if name in JOINTS else "")

    def ends(self, name: str) -> str:
        """Spring with preload, and stops of which the lower carries the preload at rest."""
        value, (finger, kind) = self.value, name.split("_")
        spring, preload = (self.own(name, f"spring_{x}") for x in ("stiffness", "preload"))
        stop, damping = (self.own(name, f"stop_{x}") for x in ("stiffness", "damping"))
        rest, end = value[f"{finger}.rest_{kind}"], value[f"{finger}.end_{kind}"]
        return (
            f'stiffness="{spring}" springref="{rest - preload / spring}" limited="true" '
            f'range="{rest + preload / stop} {end}" solimplimit="{self.impedance}" '
            f'solreflimit="{self.soft(name, stop, damping)}"'
        )

    def phalanx(self, finger: str, link: str) -> str:
        """Capsule of a phalanx."""
        length, radius = self.value[f"{finger}.{link}_length"], self.value[f"{finger}.radius"]
        return (
            f'<geom name="{finger}_{link}" type="capsule" fromto="0 0 0 {length} 0 0" '
            f'size="{radius}" contype="0" conaffinity="0"/>'
        )

    def pair(self, geom: str) -> str:
        """Contact of a phalanx with the object."""
        normal, damping, friction, width = (
            self.value[f"object.{x}"] for x in ("stiffness", "damping", "friction", "slip_speed")
        )
        return (
            f'<pair geom1="object" geom2="{geom}" condim="3" friction="{friction} {friction}" '
            f'solimp="{self.impedance}" solref="{self.soft(geom, normal, damping)}" '
            f'solreffriction="{self.soft(geom, 1.0, friction * GRIP / width)}"/>'
        )

    def wire(self, name: str) -> str:
        """A wire as a linear function of joints that is free up to its length at rest."""
        kind = name.split("_")[0]
        stiffness, damping = (self.value[f"{kind}.{x}"] for x in ("stiffness", "damping"))
        parts = {
            joint: sign * arm
            for end, sign in WAYS[name].items()
            for joint, arm in self.arms[end].items()
        }
        slack = sum(arm * self.rest(joint) for joint, arm in parts.items())
        slack += self.idiom.loose if name == "leader" else 0.0
        free = f"{slack - 10.0} {slack}"
        law = f'stiffness="{stiffness}" damping="{damping}" springlength="{free}"'
        if self.idiom.limits:
            law = f'limited="true" range="{free}" solimplimit="{self.impedance}" '
            law += f'solreflimit="{self.soft(name, stiffness, damping)}"'
        joints = "".join(f'<joint joint="{j}" coef="{arm}"/>' for j, arm in parts.items())
        return f'<fixed name="{name}" {law}>{joints}</fixed>'

    def rest(self, joint: str) -> float:
        """Angle at rest [rad], 0 for motor and carts."""
        return self.value[".rest_".join(joint.split("_"))] if joint in JOINTS else 0.0


def model(
    hand: Hand, idiom: Idiom, integrator: str, userdata: int, grasps: bool = True
) -> mujoco.MjModel:
    """MuJoCo's model; written twice, because MuJoCo first has to compute its inverse weights."""
    first = Writer(hand, idiom, userdata, {}, grasps).text(integrator)
    weights = _weights(mujoco.MjModel.from_xml_string(first))
    written = Writer(hand, idiom, userdata, weights, grasps).text(integrator)
    return mujoco.MjModel.from_xml_string(written)


def _weights(m: mujoco.MjModel) -> dict[str, float]:
    """Inverse inertia of each joint, tendon and phalanx as MuJoCo's constraints take it."""
    weights = {m.joint(k).name: m.dof_invweight0[k] for k in range(m.njnt)}
    weights |= {m.tendon(k).name: m.tendon_invweight0[k] for k in range(m.ntendon)}
    for finger in FINGERS:
        for joint, link in LINKS.items():
            weights[f"{finger}_{link}"] = m.body(f"{finger}_{joint}").invweight0[0]
    return weights
