"""Floating object: held by nothing but fingers and palm, it moves and turns in the fingers' planes.

The paper's objects do not move. Here the object is a rigid plate with three freedoms, the same in
all planes z = const: on it act the phalanges, its weight, and the palm, a wall x = const between
fingers and thumb, into which closing fingers press what they hold. The wall's contact is that of a
phalanx: eq. 3 and sliding friction.
"""

import math

from hannes.contact.leaning import support
from hannes.contact.penalty import normal_law, tangential_law
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter


@kernel
def carried(free, shift_x, shift_y, turned, speed_x, speed_y, spin):
    """Shift of the object in the hand frame [m], its turn [rad], and the rates of its states."""
    moving = free * speed_x, free * speed_y, free * spin
    return shift_x, shift_y, turned, moving[0], moving[1], moving[2]


@kernel
def touched(facing, place, cosine, sine, start_x, start_y, centre_x, centre_y, across_x, across_y):
    """Where a phalanx touches, from the object's centre, and the normal there, in the hand frame.

    `across`: its radius along the normal in the finger's plane [m].
    """
    x = start_x + place * cosine - across_x - centre_x
    y = start_y - place * sine - across_y - centre_y
    return x, facing * y


@kernel
def fleeing(
    speed_x, speed_y, spin, facing, place, cosine, sine, start_x, start_y, centre_x, centre_y,
    normal_x, normal_y, phalanx_radius,
):  # fmt: skip
    """Added to a phalanx' rate of depth and slip, because the object's surface moves [m/s]."""
    x, y = touched(
        facing, place, cosine, sine, start_x, start_y, centre_x, centre_y,
        phalanx_radius * normal_x, phalanx_radius * normal_y,
    )  # fmt: skip
    surface_x, surface_y = speed_x - spin * y, facing * (speed_y + spin * x)
    along = normal_y * surface_x - normal_x * surface_y
    return normal_x * surface_x + normal_y * surface_y, along


@kernel
def pressed(off, turned, speed_x, speed_y, spin, section, material):
    """Force of the palm towards x and friction along it, towards y [N], and where both act [m].

    off: from the palm to the object's centre [m]; section: the object's own cross-section and its
    frame; material: stiffness, damping, onset, friction and slip speed.
    """
    half_x, half_y, radius, xx, xy, yx, yy = section
    stiffness, damping, onset, friction, slip_speed = material
    cosine, sine = math.cos(turned), math.sin(turned)
    reach, aside, _ = support(
        -1.0, 0.0,
        (half_x, half_y, radius, cosine * xx - sine * yx, cosine * xy - sine * yy,
         sine * xx + cosine * yx, sine * xy + cosine * yy),
    )  # fmt: skip
    x, y = -reach, -aside
    force = max(0.0, normal_law(reach - off, spin * y - speed_x, stiffness, damping, onset))
    return force, -tangential_law(force, speed_y + spin * x, friction, slip_speed), x, y


@kernel
def driven(
    free, mass, gyration, palm, turned, speed_x, speed_y, spin, facing, mount_x, place, cosine,
    sine, start_x, start_y, centre_x, centre_y, normal_x, normal_y, phalanx_radius, normal_force,
    drag, gravity_x, gravity_y, middle_half_x, middle_half_y, middle_radius, frame_xx, frame_xy,
    frame_yx, frame_yy, object_stiffness, object_damping, object_onset, object_friction,
    object_slip_speed,
):  # fmt: skip
    """Force of the palm [N], power of the fingers [W], accelerations [m/s2, rad/s2]."""
    force_x, force_y, torque, power = 0.0, 0.0, 0.0, 0.0
    for k in range(10):
        side, normal = facing[k // 2], normal_force[k]
        x, y = touched(
            side, place[k], cosine[k], sine[k], start_x[k], start_y[k], centre_x[k], centre_y[k],
            phalanx_radius[k] * normal_x[k], phalanx_radius[k] * normal_y[k],
        )  # fmt: skip
        push_x = -normal * normal_x[k] - drag[k] * normal_y[k]
        push_y = side * (-normal * normal_y[k] + drag[k] * normal_x[k])
        force_x, force_y, torque = force_x + push_x, force_y + push_y, torque + x * push_y
        torque -= y * push_x
        power += push_x * (speed_x - spin * y) + push_y * (speed_y + spin * x)
    off = centre_x[0] + mount_x[0] - palm
    section = (
        middle_half_x, middle_half_y, middle_radius, frame_xx, frame_xy, frame_yx, frame_yy
    )  # fmt: skip
    material = object_stiffness, object_damping, object_onset, object_friction, object_slip_speed
    wall, rub, x, y = pressed(off, turned, speed_x, speed_y, spin, section, material)
    force_x, force_y, torque = force_x + wall, force_y + rub, torque + x * rub - y * wall
    by_x, by_y = free * (force_x / mass + gravity_x), free * (force_y / mass + gravity_y)
    return wall, free * power, by_x, by_y, free * torque / (mass * gyration * gyration)


LAW = Effect(
    name="floating_object",
    meaning="The object is held by fingers and palm alone: it moves and turns until they balance.",
    equation="m x'' = sum F_x + F_palm + m g_x, m y'' = sum F_y + m g_y, m s^2 angle'' = sum r x F",
    source="Newton and Euler for a plane body; the contacts are the paper's eq. 3",
    parameters=(
        Parameter("free", 0.0, "1", (0.0, 1.0), "1 where it floats, 0 fixed to the bench", off=0.0),
        Parameter("mass", 0.15, "kg", (1e-3, 1e3), "of the object"),
        Parameter("gyration", 0.02, "m", (1e-3, 0.2), "radius of gyration about z"),
        Parameter("palm", -0.012, "m", (-0.3, 0.3), "x of the palm's surface, in the hand frame"),
    ),
    terms=(
        Term(
            carried,
            writes=("object_x", "object_y", "object_angle"),
            states=("shift_x", "shift_y", "turned"),
        ),
        Term(fleeing, writes=("penetration_rate", "slip_speed")),
        Term(driven, writes=("palm_force", "object_power"), states=("speed_x", "speed_y", "spin")),
    ),
    states=(
        Slot("shift_x", "m", "towards the fingertips", tolerance=1e-6),
        Slot("shift_y", "m", "out of the palm's back", tolerance=1e-6),
        Slot("turned", "rad", "about z, from x to y", tolerance=1e-5),
        Slot("speed_x", "m/s", "of the object", tolerance=1e-4),
        Slot("speed_y", "m/s", "of the object", tolerance=1e-4),
        Slot("spin", "rad/s", "of the object", tolerance=1e-2),
    ),
)
