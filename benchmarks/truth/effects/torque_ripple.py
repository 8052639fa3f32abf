"""Torque ripple (cogging): magnets that pull the rotor towards preferred angles.

    J w' += amplitude sin(cycles th + phase)

th: motor angle. Source: Hanselman (2003), brushless permanent-magnet motor design, cogging torque.
Range: 2 % to 60 % of the nominal dry friction, 1 to 12 times a motor turn (above 10 times the 1 kHz
recording cannot show it at full speed).
"""

from math import sin

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "amplitude": Size("N m", 0.1e-3, 3e-3),
    "cycles": Size("1", 1.0, 12.0, default=4.0, amplitude=False),
    "phase": Size("rad", -3.2, 3.2, amplitude=False),
}


@compiled
def cogging(h, angle):
    """Torque (N m) on the rotor at the motor's angle (rad)."""
    amplitude = h.torque_ripple_amplitude
    return amplitude * sin(h.torque_ripple_cycles * angle + h.torque_ripple_phase)
