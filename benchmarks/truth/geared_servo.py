"""A geared position servo that swings a load: two bodies, contact, and friction that holds.

    J dv/dt  = k i - W sin(q + a) - F(v),   i = (d V - k v) / R,   d = clip(gain (r - q), limit)

all at the output shaft. Dry friction is no function of speed: a body whose drive stays below it
rests (Karnopp 1985). With play there are two bodies, the geared rotor and the shaft that carries
the load and the sensor; the faces of the gear are springs with damping, taken up in turn. The
explicit midpoint rule in steps of STEP. It has no firmware period and no encoder: what a bench adds
is in benchmarks/naming_study/servo_bench.py. SI units.

Effects, each 0 where it is absent: `delay` of the command [s]; `load_share`, friction per torque of
the load [1]; `peak` at `peak_speed`, friction of the first motion [N m, rad/s] by sqrt(2 e) T u
exp(-u^2), u = v / (sqrt(2) v_p) (Armstrong & Canudas de Wit 1995); `gap` of the gear [rad] with
the shaft's own dry friction `shaft_dry`; `swallowed` duty [1]; `source`, resistance of the supply
[ohm]; `heavier`, torque of a further load [N m]; `tilted`, angle of its mount [rad].
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from benchmarks.truth._jit import compiled, inlined

MACHINE = ("inertia", "constant", "resistance", "voltage", "gain", "limit", "dry", "viscous",
           "weight", "angle")  # fmt: skip
EFFECTS = ("delay", "load_share", "peak", "peak_speed", "gap", "shaft_dry", "swallowed", "source",
           "heavier", "tilted")  # fmt: skip
NAMES = MACHINE + EFFECTS
# A servo of 2.7 N m on 7.4 V through 300 to 1, with a load of 0.4 N m.
SERVO: Mapping[str, float] = MappingProxyType(dict(zip(
    MACHINE, (9e-3, 0.9, 2.5, 7.4, 8.0, 1.0, 0.15, 0.045, 0.4, 0.3), strict=True)))  # fmt: skip
NOTHING: Mapping[str, float] = MappingProxyType(
    dict.fromkeys(EFFECTS, 0.0) | {"peak_speed": 0.1, "shaft_dry": 0.02}
)
STEP = 5e-5  # s
SHAFT = 0.1  # of the inertia, that is beyond the play
FACE = 3000.0  # N m/rad, of a face of the gear
REST = 1e-9  # rad/s


@inlined
def drawn(p, duty, speed):
    """Current [A] at a duty, and with a source that sags by what it gives."""
    if duty > 0.0:
        duty = max(duty - p[16], 0.0)
    else:
        duty = min(duty + p[16], 0.0)
    current = (duty * p[3] - p[1] * speed) / p[2]
    for _ in range(60 if p[17] > 0.0 else 0):
        current += 0.5 * ((duty * (p[3] - p[17] * duty * current) - p[1] * speed) / p[2] - current)
    return current


@inlined
def weight(p, q):
    """Torque of the load on the shaft [N m]."""
    return (p[8] + p[18]) * np.sin(q + p[9] + p[19])


@inlined
def held(p, load):
    """Dry friction of motor and gear at a load [N m]."""
    return p[6] + p[11] * abs(load)


@inlined
def slowed(p, v):
    """What grows or falls with speed [N m], against the motion."""
    u = v / (np.sqrt(2.0) * p[13])
    return p[7] * v + np.sqrt(2.0 * np.e) * p[12] * u * np.exp(-u * u)


@inlined
def next_speed(v, push, dry, inertia, h):
    """Speed after h under a torque and dry friction: at rest until it is overcome."""
    if abs(v) < REST:
        if abs(push) <= dry:
            return 0.0
        return h * (push - np.sign(push) * dry) / inertia
    new = v + h * (push - np.sign(v) * dry) / inertia
    return 0.0 if new * v < 0.0 else new


@compiled
def moved(p, times, asked, parts, out):
    """Fill out (n, 3): sensor's position, duty, current; asked: command from each time on."""
    q, v = asked[1, 0], 0.0  # shaft
    rotor, w = q + 0.5 * p[14] * np.sign(weight(p, q)), 0.0  # the shaft lies on a face
    place = 0
    for k in range(times.size):
        for part in range(parts):
            t = times[k] + part * (times[1] - times[0]) / parts
            h = (times[1] - times[0]) / parts
            if part == 0:  # the sensors are read before the command of this time is sent
                duty = min(max(p[4] * (asked[1, place] - q), -p[5]), p[5])
                out[k, 0], out[k, 1], out[k, 2] = q, duty, drawn(p, duty, w)
            while place + 1 < asked.shape[1] and asked[0, place + 1] <= t - p[10] + 1e-12:
                place += 1
            duty = min(max(p[4] * (asked[1, place] - q), -p[5]), p[5])
            current = drawn(p, duty, w)
            load = weight(p, q)
            if p[14] == 0.0:
                middle = next_speed(w, p[1] * current - load - slowed(p, w), held(p, load), p[0],
                                    0.5 * h)  # fmt: skip
                at = q + 0.5 * h * w
                duty = min(max(p[4] * (asked[1, place] - at), -p[5]), p[5])
                load = weight(p, at)
                push = p[1] * drawn(p, duty, middle) - load - slowed(p, middle)
                new = next_speed(w, push, held(p, load), p[0], h)
                q += 0.5 * h * (w + new)
                w = new
                rotor, v = q, w
            else:
                apart = rotor - q
                push = 0.0
                if abs(apart) > 0.5 * p[14]:
                    deep = apart - np.sign(apart) * 0.5 * p[14]
                    push = FACE * deep + 2.0 * np.sqrt(FACE * SHAFT * p[0]) * (w - v)
                    if push * apart < 0.0:
                        push = 0.0  # a face does not pull
                v = next_speed(v, push - load, p[15], SHAFT * p[0], h)
                q += h * v
                rest = (1.0 - SHAFT) * p[0]
                w = next_speed(w, p[1] * current - push - slowed(p, w), held(p, load), rest, h)
                rotor += h * w


def simulate(
    values: Mapping[str, float], times: np.ndarray, asked: np.ndarray
) -> dict[str, np.ndarray]:
    """Channels time, reference, position, duty, current at evenly spaced `times`, shape (n,).

    values: by NAMES, in place of SERVO's and of no effect;  asked: times and commands, (2, m)
    """
    p = np.array([{**SERVO, **NOTHING, **values}[name] for name in NAMES])
    parts = max(1, int(np.ceil((times[1] - times[0]) / STEP - 1e-9)))
    out = np.zeros((times.size, 3))
    moved(p, times, np.ascontiguousarray(asked), parts, out)
    position, duty, current = out.T.copy()
    held_at = np.maximum(np.searchsorted(asked[0], times + 1e-12, "right") - 1, 0)
    return {
        "time": times, "reference": asked[1][held_at],
        "position": position, "duty": duty, "current": current,
    }  # fmt: skip
