"""Outside the catalogue: a tooth of the output wheel that rubs each time it meshes.

    T_friction += torque exp((cos(th / N - angle) - 1) / 0.15^2) tanh(w / w_s)

th, w: motor angle and speed; w_s: `motor.friction_speed`. The bell is 0.15 rad wide and comes once
in a turn of the output wheel. Source: local faults of gear teeth, which come back once a turn (ISO
10825-1, wear and damage to gear teeth). Range: 10 % to 130 % of the nominal dry friction.
"""

from math import cos, exp, tanh

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "torque": Size("N m", 0.4e-3, 6e-3),
    "angle": Size("rad", -3.14, 3.14, default=2.0, amplitude=False),
}
WIDTH = 0.15  # rad, at the output wheel


@compiled
def rotor_torque(h, angle, speed, load):
    """Torque (N m) against the rotor."""
    if h.damaged_tooth_torque == 0.0:
        return 0.0
    off = cos(angle / h.gear_ratio - h.damaged_tooth_angle) - 1.0
    meshing = h.damaged_tooth_torque * exp(off / (WIDTH * WIDTH))
    return meshing * tanh(speed / h.motor_friction_speed)
