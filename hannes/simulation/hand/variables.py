"""The hand's states, channels and outputs, and the list of its parts' parameters."""

from hannes.contact import penalty
from hannes.control import drive, encoder, pid
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter
from hannes.dynamics import carts, joints, motor, wires
from hannes.simulation.hand import anatomy, joint_shares

# Ten joints or phalanges are worked on as twelve, in whole vector registers of four; what the last
# two hold is finite and counts for nothing.
LANES = 12
SIZES = {"cart": 2, "finger": 5, "joint": 10, "phalanx": 10, "lane": LANES}


def _slots(axis: str, rows: str, room: int = 0) -> tuple[Slot, ...]:
    """Read `name unit doc` lines, one slot each; a fourth field before doc is a tolerance."""
    slots = []
    for row in rows.strip().splitlines():
        name, unit, rest = (part.strip() for part in row.split("|", 2))
        tolerance, _, doc = rest.rpartition("|")
        size = SIZES.get(axis, 1)
        slots.append(Slot(name, unit, doc.strip(), axis, size, float(tolerance or 1e-6), room))
    return tuple(slots)


STATES = (
    _slots(
        "",
        """
        motor_angle       | rad | 1e-3 | motor side
        motor_speed       | rad/s | 1e-3 | motor side
        motor_current     | A | 1e-4 | winding
        position_integral | A | 1e-4 | integral term of the position PID
        position_lag      | rad | 1e-4 | filtered motor-side position, for its derivative
        current_integral  | V | 1e-3 | integral term of the current PID
        current_lag       | A | 1e-3 | filtered current, for its derivative
        """,
    )
    + _slots(
        "cart",
        """
        cart_position | m | 1e-7 | along the pull, 0 at rest
        cart_speed    | m/s | 1e-4 | along the pull
        """,
    )
    + _slots(
        "joint",
        """
        joint_angle | rad | 1e-5 | closing positive; index MCP, index PIP, middle MCP, ...
        joint_speed | rad/s | 1e-3 | closing positive
        """,
    )
)

# Local variables of the stages that effects may read as well, once they are known there.
NUMBERS = _slots(
    "",
    """
    target         | rad | where the output shaft should be
    held_position  | rad | of the shaft, as the firmware probed it last
    held_current   | A | as the firmware probed it last
    current        | A | in the winding
    speed          | rad/s | of the motor, motor side
    arm            | m | leader wire wound for each radian of the motor
    stretch        | m | of the leader wire, negative while slack
    rate           | m/s | of its stretch
    stiffness      | N/m | of the leader wire
    rate_a         | m/s | of cart A along the pull
    rate_b         | m/s | of cart B along the pull
    rate_thumb     | m/s | of the thumb's flexor wire
    load           | N m | of the leader wire on the motor, motor side
    touching       | 1 | number of phalanges that touch the object
    """,
)

# Quantities that effects may read, and add to where equations.py opens them.
CHANNELS = (
    _slots(
        "",
        """
        reference_time    | s | time at which the reference is read
        reading_age       | s | of what the firmware reads of the sensors
        shaft_position    | rad | of the output shaft, where the encoder sits
        sensed_current    | A | in the current sensor
        delayed_position  | rad | when it reaches the controller and the log
        delayed_current   | A | when it reaches the controller and the log
        measured_position | rad | reading of the encoder, at the output shaft
        measured_current  | A | reading of the current sensor
        position_error    | rad | that the position loop acts on, motor side
        duty              | 1 | of the PWM drive, as it reaches the motor
        supply            | V | bus voltage
        voltage           | V | at the motor's terminals
        resistance        | ohm | of the winding
        torque_constant   | N m/A | of the motor
        slack             | m | free length of the leader wire
        leader_compliance | m/N | of the leader wire
        follower_compliance | m/N | of each follower wire
        leader_stretch    | m | of the leader wire, negative while slack
        leader_rate       | m/s | of its stretch
        leader_stiffness  | N/m | of the leader wire
        follower_stiffness | N/m | of each follower wire
        leader_tension    | N | at the motor pulley
        pull_a            | N | leader tension at cart A, mean of both sides of its pulley
        pull_b            | N | leader tension at cart B, mean of both sides of its pulley
        pull_thumb        | N | leader tension at the thumb
        gear_friction     | N m | opposing the motor, motor side
        motor_torque      | N m | further torque on the rotor, motor side
        object_x          | m | of the object in the hand frame
        object_y          | m | of the object in the hand frame
        object_angle      | rad | by which it has turned about z since it was put there
        palm_force        | N | of the palm on the object
        object_power      | W | by the fingers into the motion of the object
        """,
    )
    + _slots(
        "cart",
        """
        leader_pull      | N | leader tension at the cart
        cart_friction    | N | opposing the cart
        follower_stretch | m | of the follower wire, negative while slack
        follower_rate    | m/s | of its stretch
        follower_slip    | m/s | of the follower wire over the pulley, from the first finger
        follower_loss    | 1 | share of its tension that the first finger lacks, the second has more
        """,
    )
    + _slots(
        "finger",
        """
        excursion      | m | flexor wire taken up by the finger
        excursion_rate | m/s | of the flexor wire
        tendon_tension | N | flexor wire at the finger
        logged_force     | N | sum of the normal forces on the finger, as it is logged
        logged_sensor    | N | on the dynamometer's sensing face by the finger, as it is logged
        """,
    )
    + _slots(
        "joint",
        """
        lane_angle     | rad | the state joint_angle
        lane_speed     | rad/s | the state joint_speed
        bend_cosine    | 1 | of the joint's angle
        bend_sine      | 1 | of the joint's angle
        cosine         | 1 | of the direction of the link that starts at the joint
        sine           | 1 | of the direction of the link that starts at the joint
        joint_friction | N m | opposing the joint
        spring_torque  | N m | re-opening
        stop_torque    | N m | of both end stops, closing positive
        joint_torque   | N m | everything that acts on the joint
        """,
        LANES,
    )
    + _slots(
        "phalanx",
        """
        penetration      | m | into the object
        penetration_rate | m/s | into the object
        normal_force     | N | of the object on the phalanx
        drag             | N | of the object along the phalanx, against its slip
        held_drag        | N | part of it that does not depend on the slip's speed alone
        place            | m | of the contact along the phalanx, from its joint
        normal_x         | 1 | out of the object, in the finger's plane
        normal_y         | 1 | out of the object, in the finger's plane
        slip_speed       | m/s | of the phalanx along the object
        start_x          | m | of the phalanx's joint, in the finger's plane
        start_y          | m | of the phalanx's joint, in the finger's plane
        centre_x         | m | of the object, in the finger's plane
        centre_y         | m | of the object, in the finger's plane
        normal_arm_mcp   | m | of the normal force about the finger's MCP
        normal_arm_pip   | m | of the normal force about the finger's PIP
        slip_arm_mcp     | m | of the tangential force about the finger's MCP
        slip_arm_pip     | m | of the tangential force about the finger's PIP
        torque_mcp       | N m | of the contact about the finger's MCP
        torque_pip       | N m | of the contact about the finger's PIP
        own_angle_slope  | N m/rad | of a joint's torque but for contacts, by its angle
        own_speed_slope  | N m s/rad | of the same by its speed
        mcp_angle_slope  | N m/rad | of a joint's torque by contacts, by its finger's MCP
        pip_angle_slope  | N m/rad | of the same by PIP
        mcp_speed_slope  | N m s/rad | of the same by the speed of MCP
        pip_speed_slope  | N m s/rad | of the same by the speed of PIP
        mcp_by_mcp       | N m s/rad | of torque_mcp by the speed of MCP
        pip_by_mcp       | N m s/rad | of torque_pip by the speed of MCP
        mcp_by_pip       | N m s/rad | of torque_mcp by the speed of PIP
        pip_by_pip       | N m s/rad | of torque_pip by the speed of PIP
        pressing         | N s/m | of normal_force by penetration_rate, as far as effects make it
        held_mcp         | N m | torque_mcp before a difference
        held_pip         | N m | torque_pip before a difference
        """,
        LANES,
    )
)

OUTPUTS = (
    _slots(
        "",
        """
        reference        | rad | output shaft
        position         | rad | encoder at the output shaft
        current          | A | current sensor
        current_reference | A | asked by the position PID
        duty             | 1 | of the PWM drive
        supply           | V | bus
        force            | N | sum of the phalanges' normal forces
        palm_force       | N | of the palm on an object that floats
        sensor           | N | on the dynamometer's sensing face, along its axis
        leader_tension   | N | at the motor pulley
        leader_stretch   | m | of the leader wire, negative while slack
        power_electrical | W | into the motor
        power_copper     | W | lost in the winding
        power_inductance | W | into the magnetic field
        power_gear_friction | W | lost in motor and gear
        power_motor_torque | W | taken by further torques on the rotor
        power_cart_friction | W | lost at the guides
        power_joint_friction | W | lost at the joints
        power_wire_elastic | W | into stretched wires
        power_wire_damping | W | lost in wires
        power_wire_friction | W | lost where wires run over pulleys
        power_spring     | W | into the re-opening springs
        power_stop       | W | into and lost at the end stops
        power_gravity    | W | against gravity
        power_contact_normal | W | into the object, stored and damped
        power_contact_tangential | W | lost by sliding on the object
        power_object     | W | into the motion of an object that floats
        energy_kinetic   | J | rotor, carts and phalanges
        """,
    )
    + _slots("cart", "follower_tension | N | of each follower wire")
    + _slots("phalanx", "phalanx_force | N | normal force at each phalanx")
)

PARAMETERS: tuple[Parameter, ...] = (
    *motor.PARAMETERS,
    *wires.PARAMETERS,
    *carts.PARAMETERS,
    *joints.PARAMETERS,
    *anatomy.PARAMETERS,
    *joint_shares.PARAMETERS,
    *drive.PARAMETERS,
    *encoder.PARAMETERS,
    *pid.PARAMETERS,
    *penalty.PARAMETERS,
)


# One compiled array for each table; every other parameter is a number of its own. Tables of joints
# and phalanges are filled up with their last entry.
TABLES = {
    name: names if len(names) < 10 else names + names[-1:] * (LANES - len(names))
    for name, names in anatomy.TABLES.items()
}
_TABLED = {name for names in TABLES.values() for name in names}
_SINGLES = tuple(each for each in PARAMETERS if each.name not in _TABLED and not each.shared)
_AXES = {5: "finger", LANES: "joint"}

# What an object and the hand's build come to, beside the values of parameters.
DERIVED_SLOTS = (
    Slot("object_present", "1", "1 where there is an object"),
    Slot("object_flat", "1", "1 where its sections have flat sides, 2 where they lean"),
    *_slots(
        "finger",
        """
        section_half_x | m | of the section's core in the finger's plane
        section_half_y | m | of the section's core in the finger's plane
        section_aside_x | m | of its centre from the object's, in the hand frame
        section_aside_y | m | of its centre from the object's, in the hand frame
        """,
    ),
    *_slots(
        "",
        """
        middle_half_x | m | core of the object's own cross-section
        middle_half_y | m | core of the object's own cross-section
        middle_radius | m | of the object's own cross-section
        frame_xx | 1 | see contact/shapes.py
        frame_xy | 1 | see contact/shapes.py
        frame_yx | 1 | see contact/shapes.py
        frame_yy | 1 | see contact/shapes.py
        """,
    ),
    *_slots(
        "lane",
        """
        reach  | m | from the section's core to where the phalanx's axis touches; -1 where it can't
        distal | 1 | 1 for the phalanx beyond PIP
        """,
    ),
)

PARAMETER_SLOTS = (
    *(Slot(each.name.replace(".", "_"), each.unit, each.doc) for each in _SINGLES),
    *(Slot(name, "", "", _AXES[len(names)], len(names)) for name, names in TABLES.items()),
    *DERIVED_SLOTS,
)
# Full names of the parameters in the order of their slots, which DERIVED_SLOTS follow.
PACKED = (
    *(each.name for each in _SINGLES),
    *(name for names in TABLES.values() for name in names),
)
