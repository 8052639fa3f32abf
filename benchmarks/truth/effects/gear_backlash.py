"""Gear backlash: play between the motor and the output shaft, which carries pulley and encoder.

    shaft phi free while |th/N - phi| < gap/2;  teeth carry r_p T_L else;  position = phi

th: motor angle; gap: the whole play at the output shaft, at rest in its middle. Rigid teeth and a
shaft without mass are meant; here the teeth are a spring (300 N m/rad, 0.02 N m s/rad) and the
shaft has 2e-7 kg m2 and 1e-6 N m s/rad: at no gap, nothing that a sensor sees.
Nearly invisible while the wire pulls one face: it shows at the start, where the motor crosses half
the gap, and wherever the wire falls slack.
Source: dead-zone model, Nordin & Gutman (2002). Range: 0.1 to 3 degrees at the output.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"gap": Size("rad", 2e-3, 50e-3)}
STIFFNESS, DAMPING = 300.0, 0.02  # N m/rad, N m s/rad, at the output shaft
INERTIA, DRAG = 2e-7, 1e-6  # kg m2, N m s/rad


@compiled
def teeth(h, lead, rate):
    """Torque (N m) from motor to shaft; lead: by how much the motor is ahead (rad, rad/s)."""
    side = 1.0 if lead > 0.0 else -1.0
    depth = side * lead - 0.5 * h.gear_backlash_gap
    if depth <= 0.0:
        return 0.0
    return side * max(0.0, STIFFNESS * depth + side * DAMPING * rate)


@compiled
def shaft_rate(torque, pull, speed):
    """Acceleration (rad/s2) of the shaft between the teeth's torque and the wire's pull (N m)."""
    return (torque - pull - DRAG * speed) / INERTIA
