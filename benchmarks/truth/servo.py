"""A plain position servo, or an axis on a screw: one mass under a sampled controller.

    inertia dv/dt = gain u - viscous v - dry tanh(v / width) - weight sin(q) - offset
    u = clip(kp (reference - q) - kd v, -limit, limit), renewed every period, q as the encoder reads

It has no electrical part: u is what the drive logs. Explicit midpoint rule, SI units.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from benchmarks.truth._jit import compiled

NAMES = ("inertia", "gain", "viscous", "dry", "width", "weight", "offset", "kp", "kd", "limit")
NAMES += ("period", "encoder")
# A hobby servo (rad, A) and a positioning axis like that of EMPS (m, V).
SERVO: Mapping[str, float] = MappingProxyType(dict(zip(
    NAMES, (2.0e-3, 0.6, 8e-3, 0.05, 0.05, 0.02, 0.0, 6.0, 0.12, 2.0, 1e-3, 2 * np.pi / 16384),
    strict=True)))  # fmt: skip
AXIS: Mapping[str, float] = MappingProxyType(dict(zip(
    NAMES, (95.0, 35.15, 203.5, 20.4, 1e-3, 0.0, -3.2, 160.18 * 243.45, 243.45, 10.0, 1e-3, 2e-7),
    strict=True)))  # fmt: skip
PARTS = 4  # steps of integration a period


@compiled
def moved(p, asked, enabled, out):
    """Fill out (n, 3): position as it is, speed, drive; asked, enabled: shape (n,)."""
    q, v, u, before = asked[0], 0.0, 0.0, asked[0]
    for k in range(asked.size):
        read = p[11] * np.round(q / p[11])
        speed = (read - before) / p[10] if k else 0.0
        before = read
        u = min(max(p[7] * (asked[k] - read) - p[8] * speed, -p[9]), p[9]) * enabled[k]
        out[k, 0], out[k, 1], out[k, 2] = q, v, u
        h = p[10] / PARTS
        for _ in range(PARTS):
            middle_q, middle_v = q + 0.5 * h * v, v + 0.5 * h * pushed(p, q, v, u)
            q, v = q + h * middle_v, v + h * pushed(p, middle_q, middle_v, u)


@compiled
def pushed(p, q, v, u):
    """Acceleration (rad/s2 or m/s2)."""
    load = p[2] * v + p[3] * np.tanh(v / p[4]) + p[5] * np.sin(q) + p[6]
    return (p[1] * u - load) / p[0]


def simulate(
    values: Mapping[str, float], asked: np.ndarray, enabled: np.ndarray | None = None
) -> dict[str, np.ndarray]:
    """Channels time, reference, position, speed, drive at every period, shape (n,).

    values: by NAMES; asked: the reference at every period; enabled: 0 where the drive is off.
    """
    p = np.array([values[name] for name in NAMES])
    out = np.zeros((asked.size, 3))
    moved(p, asked, np.ones(asked.size) if enabled is None else enabled, out)
    time = p[10] * np.arange(asked.size)
    position, speed, drive = out.T.copy()
    return {"time": time, "reference": asked, "position": position, "speed": speed, "drive": drive}
