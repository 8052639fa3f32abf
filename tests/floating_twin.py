"""A hand whose object floats, formulated a second time and integrated by scipy.

Hand and contact law are the independent truth's (benchmarks/truth, natural coordinates). What
floats is added here: rods are seen from the object, in whose frame its section stands still, so
that depth and slip are those that the truth knows; its forces go to the ends of the rods, and from
there back to the object by Newton and Euler. A vector in the hand frame is a complex number: 1j
turns it by a quarter.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numba
import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.truth.finger import contact, finger
from benchmarks.truth.integrator import reference_at
from benchmarks.truth.laws import one_sided
from benchmarks.truth.motion import rates, rest_state
from benchmarks.truth.record import pack
from benchmarks.truth.state import SIZE, SPEED, VOLTS

HAND = VOLTS + 1  # states of the hand that have rates of their own
OBJECT = {"shift_x": HAND, "shift_y": HAND + 1, "turned": HAND + 2,
          "speed_x": HAND + 3, "speed_y": HAND + 4, "spin": HAND + 5}  # fmt: skip
compiled = numba.njit(error_model="numpy")


@compiled
def torque(arm, force):
    """About the origin, of a force at the end of an arm [N m]."""
    return (arm.conjugate() * force).imag


@compiled
def touched(h, f, near, pace):
    """Force of the object on both ends of a rod [N]; ends and their speeds in its own frame."""
    section = h.section_radius[f], h.fingers_radius[f], h.section_half_x, h.section_half_y
    material = h.object_stiffness, h.object_damping, h.object_friction, h.object_onset
    hit = contact(
        (near[0].real, near[0].imag, near[1].real, near[1].imag),
        (pace[0].real, pace[0].imag, pace[1].real, pace[1].imag),
        (0.0, 0.0, *section),
        (*material, h.object_slip_speed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        0.0,
        0.0,
    )
    return complex(hit[0], hit[1]), complex(hit[2], hit[3])


@compiled
def acceleration_by(h, f, angles, torques):
    """What torques [N m] at MCP and PIP add to their accelerations [rad/s2], linearly."""
    lengths = h.fingers_proximal_length[f], h.fingers_distal_length[f]
    masses = h.fingers_proximal_mass[f], h.fingers_distal_mass[f]
    none, still = (0.0,) * 6, (0.0, 0.0)
    return finger(
        angles, still, torques, lengths, masses, still, none, (0.0,) * 11, still, 0.0
    )[0]  # fmt: skip


@compiled
def pushed(h, f, y, centre, velocity, angle, spin):
    """Accelerations of finger f's joints by contact [rad/s2], and its force [N] and torque [N m]
    on the object."""
    turn = complex(0.0, -h.fingers_side[f])  # of a rod that closes
    q, w = (y[2 * f], y[2 * f + 1]), (y[SPEED + 2 * f], y[SPEED + 2 * f + 1])
    one = h.fingers_proximal_length[f] * np.exp(turn * q[0])
    two = h.fingers_distal_length[f] * np.exp(turn * (q[0] + q[1]))
    origin = complex(h.fingers_origin_x[f], h.fingers_origin_y[f])
    ends = origin, origin + one, origin + one + two
    speeds = 0.0j, turn * one * w[0], turn * (one * w[0] + two * (w[0] + w[1]))
    seen, force, moment, mcp, pip = np.exp(-1j * angle), 0.0j, 0.0, 0.0, 0.0
    for link in range(2):
        a, b = ends[link] - centre, ends[link + 1] - centre
        near = seen * a, seen * b
        pace = (
            seen * (speeds[link] - velocity - 1j * spin * a),
            seen * (speeds[link + 1] - velocity - 1j * spin * b),
        )
        at_a, at_b = touched(h, f, near, pace)
        at_a, at_b = at_a * seen.conjugate(), at_b * seen.conjugate()
        force, moment = force - at_a - at_b, moment - torque(a, at_a) - torque(b, at_b)
        side = turn.imag
        mcp += side * (torque(ends[link] - origin, at_a) + torque(ends[link + 1] - origin, at_b))
        pip += side * link * torque(two, at_b)
    return acceleration_by(h, f, q, (mcp, pip)), force, moment


@compiled
def walled(h, palm, centre, velocity, spin):
    """Force of the palm on a round object [N] and its torque [N m]."""
    place = complex(-h.object_radius, 0.0)
    speed = velocity + 1j * spin * place
    push = one_sided(
        palm - (centre + place).real, -speed.real,
        h.object_stiffness, h.object_damping, h.object_onset,
    )  # fmt: skip
    rub = h.object_friction * push * np.tanh(speed.imag / h.object_slip_speed)
    force = complex(push, -rub)
    return force, torque(place, force)


@compiled
def moving(t, z, knots, h, bare, mass, gyration, palm):
    """Rates of all states: the truth's, of a hand that holds nothing, and what contact adds."""
    y, dy, out = np.zeros(SIZE), np.zeros(SIZE), np.zeros(z.size)
    y[:HAND] = z[:HAND]
    rates(bare, y.copy(), 0.0, reference_at(knots, t), 0.0, False, y, dy)
    x, y_, angle, speed_x, speed_y, spin = z[HAND:]
    centre, velocity = complex(h.object_x + x, h.object_y + y_), complex(speed_x, speed_y)
    force, moment = walled(h, palm, centre, velocity, spin)
    for f in range(5):
        more, push, twist = pushed(h, f, y, centre, velocity, angle, spin)
        dy[SPEED + 2 * f] += more[0]
        dy[SPEED + 2 * f + 1] += more[1]
        force, moment = force + push, moment + twist
    out[:HAND], out[HAND : HAND + 3] = dy[:HAND], z[HAND + 3 :]
    out[HAND + 3] = force.real / mass + h.gravity_x
    out[HAND + 4] = force.imag / mass + h.gravity_y
    out[HAND + 5] = moment / (mass * gyration**2)
    return out


def run(
    values: Mapping[str, Any],
    thing: Mapping[str, Any],
    floats: tuple[float, float, float],
    points: Sequence[Sequence[float]],
    times: np.ndarray,
    rtol: float,
) -> np.ndarray:
    """States at `times` [s], shape (times, HAND + 6): the truth's, then OBJECT.

    values, thing: of the truth's `pack`; floats: mass [kg], radius of gyration and palm [m].
    """
    h, bare = pack(values, thing), pack(values, thing)
    bare["section_radius"] = 0.0
    knots = np.array(points) * (1.0, h.gear_ratio)
    start = np.concatenate((rest_state(h)[:HAND], np.zeros(6)))
    found = solve_ivp(
        moving, (0.0, times[-1]), start, "LSODA", times,
        args=(knots, h, bare, *floats), rtol=rtol, atol=1e-2 * rtol,
    )  # fmt: skip
    assert found.success, found.message
    return found.y.T
