"""Outside the catalogue: iron of the motor that saturates, so that torque lags behind the current.

    T = k_t i / sqrt(1 + (inverse_current i)^2)

The torque never exceeds k_t / inverse_current. What the motor induces at speed stays k_t w: the
magnets alone make it. Source: saturation of slotted machines (Hanselman 2003, magnetic circuits).
Range: a bend at 10 A (0.1), the iron hardly loaded, to one at 1.25 A (0.8), a motor too small.
"""

from math import sqrt

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"inverse_current": Size("1/A", 0.1, 0.8)}


@compiled
def pulling(h, torque, current):
    """Torque (N m) of a current (A) that should give `torque`."""
    if h.saturating_motor_inverse_current == 0.0:
        return torque
    load = h.saturating_motor_inverse_current * current
    return torque / sqrt(1.0 + load * load)
