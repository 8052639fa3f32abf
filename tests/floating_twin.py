"""A hand whose object floats, formulated a second time and integrated by scipy.

Hand and contact law are the independent truth's (benchmarks/truth: natural coordinates). What floats
is added here: rods are seen from the object, whose section never moves in its own frame, so that
speeds of depth and slip follow by themselves; the forces go to the ends of the rods, and from
there back to the object by Newton and Euler.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.truth.finger import contact, finger
from benchmarks.truth.integrator import reference_at
from benchmarks.truth.laws import one_sided
from benchmarks.truth.motion import rates, rest_state
from benchmarks.truth.record import pack
from benchmarks.truth.state import ANGLE, SIZE, SPEED, VOLTS

HAND = VOLTS + 1  # states of the hand that have rates of their own
SHIFT, PACE = slice(HAND, HAND + 3), slice(HAND + 3, HAND + 6)  # x, y, angle, and their rates
NOTHING = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # a section that is not there


def turned(angle):
    """Rotation by an angle, shape (2, 2)."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def across(vector):
    """A vector turned by a quarter: what a unit of spin moves its end by."""
    return np.array([-vector[1], vector[0]])


@dataclass(frozen=True)
class Twin:
    """values, thing: of the truth's `pack`; mass [kg], gyration and palm [m] of what floats."""

    values: dict
    thing: dict
    mass: float
    gyration: float
    palm: float

    def __post_init__(self):
        posed, bare = pack(self.values, self.thing), pack(self.values, self.thing)
        bare["section_radius"] = 0.0
        place = np.array([posed.object_x, posed.object_y])
        vars(self).update(posed=posed, bare=bare, place=place)

    def run(self, points, times, **options):
        """States at `times` [s], shape (times, HAND + 6)."""
        knots = np.array(points) * (1.0, self.posed.gear_ratio)
        start = np.concatenate((rest_state(self.posed)[:HAND], np.zeros(6)))
        found = solve_ivp(
            self.rates, (0.0, times[-1]), start, "LSODA", times, args=(knots,), **options
        )
        assert found.success, found.message
        return found.y.T

    def rates(self, t, z, knots):
        """Rates of all states."""
        y, dy = np.zeros(SIZE), np.zeros(SIZE)
        y[:HAND] = z[:HAND]
        rates(self.bare, y.copy(), 0.0, reference_at(knots, t), 0.0, False, y, dy)
        dy[SPEED : SPEED + 10] += self.pushed(z)[0]
        return np.concatenate((dy[:HAND], z[PACE], self.moved(z)))

    def moved(self, z):
        """Accelerations of the object, linear [m/s2] and angular [rad/s2]."""
        force, torque = self.pushed(z)[1:]
        wall, place = self.wall(z)
        force, torque = force + wall, torque + across(place) @ wall
        gravity = np.array([self.posed.gravity_x, self.posed.gravity_y])
        return *(force / self.mass + gravity), torque / (self.mass * self.gyration**2)

    def pushed(self, z):
        """What contact adds to joints' accelerations [rad/s2]; force [N] and torque [N m] of all
        phalanges on the object."""
        bent, force, torque = np.zeros(10), np.zeros(2), 0.0
        for f in range(5):
            ends, jacobians, speeds = self.ends(z, f)
            load = np.zeros(2)
            for link in range(2):
                pair = slice(link, link + 2)
                hit = self.touched(z, f, ends[pair], speeds[pair])
                load += sum(j.T @ each for j, each in zip(jacobians[pair], hit, strict=True))
                force = force - hit.sum(axis=0)
                centre = self.place + z[SHIFT][:2]
                torque -= sum(across(e - centre) @ x for e, x in zip(ends[pair], hit, strict=True))
            bent[2 * f : 2 * f + 2] = self.given(z, f, load)
        return bent, force, torque

    def ends(self, z, f):
        """MCP axis, PIP axis and tip in the hand frame, how joints move them, and their speeds."""
        h, q, w = self.posed, z[ANGLE + 2 * f :][:2], z[SPEED + 2 * f :][:2]
        side, a = h.fingers_side[f], q[0] + q[1]
        origin = np.array([h.fingers_origin_x[f], h.fingers_origin_y[f]])
        one = h.fingers_proximal_length[f] * np.array([np.cos(q[0]), -side * np.sin(q[0])])
        two = h.fingers_distal_length[f] * np.array([np.cos(a), -side * np.sin(a)])
        along, further = -side * across(one), -side * across(two)  # by an angle of closing
        still = np.zeros((2, 2))
        jacobians = [still, np.stack([along, 0 * along], 1), np.stack([along + further, further], 1)]
        places = np.array([origin, origin + one, origin + one + two])
        return places, jacobians, np.array([j @ w for j in jacobians])

    def touched(self, z, f, ends, speeds):
        """Force of the object on both ends of a rod [N], shape (2, 2)."""
        h, seen = self.posed, turned(-z[SHIFT][2])
        away = ends - self.place - z[SHIFT][:2]
        passing = speeds - z[PACE][:2] - z[PACE][2] * np.array([across(each) for each in away])
        box = h.section_radius[f], h.fingers_radius[f], h.section_half_x, h.section_half_y
        law = (
            *(h.object_stiffness, h.object_damping, h.object_friction),
            *(h.object_onset, h.object_slip_speed, 0.0, 0.0, 0.0, 0.0),
        )
        near, pace = (seen @ away.T).T.ravel(), (seen @ passing.T).T.ravel()
        hit = contact(tuple(near), tuple(pace), (0.0, 0.0, *box), law, 0.0, 0.0)[:4]
        return np.array(hit).reshape(2, 2) @ seen

    def given(self, z, f, load):
        """What torques [N m] at MCP and PIP add to the accelerations: they enter linearly."""
        h, angles = self.posed, tuple(z[ANGLE + 2 * f :][:2])
        lengths = h.fingers_proximal_length[f], h.fingers_distal_length[f]
        masses = h.fingers_proximal_mass[f], h.fingers_distal_mass[f]
        still, law = (0.0, 0.0), (0.0,) * 9
        found = finger(angles, still, tuple(load), lengths, masses, still, NOTHING, law, still, 0.0)
        return found[0]

    def wall(self, z):
        """Force of the palm [N] and where it acts from the object's centre [m], by its corners."""
        h, angle = self.posed, z[SHIFT][2]
        half = h.section_half_x, h.section_half_y
        corners = [turned(angle) @ (i * half[0], j * half[1]) for i in (-1, 1) for j in (-1, 1)]
        lowest = min(corners, key=lambda corner: corner[0])
        place = lowest - (h.object_radius if half == (0.0, 0.0) else h.section_radius[0], 0.0)
        depth = self.palm - (self.place[0] + z[SHIFT][0] + place[0])
        speed = z[PACE][:2] + z[PACE][2] * across(place)
        push = one_sided(
            depth, -speed[0], h.object_stiffness, h.object_damping, h.object_onset
        )
        rub = h.object_friction * push * np.tanh(speed[1] / h.object_slip_speed)
        return np.array([push, -rub]), place
