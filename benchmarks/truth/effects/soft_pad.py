"""Outside the catalogue: fingers that wear soft pads, which are flat before the finger presses.

    F_n += stiffness min(max(0, x + thickness), thickness)

x: depth of the bare finger in the object, below 0 where it is off. So contact begins earlier by
`thickness`, softly, and once the pad is flat the object's own law joins. Left out: losses in the
pad. Source: layered fingertips of robot hands (Shimoga & Goldenberg 1996). Range: tape (0.3 mm) to
a foam sleeve (4 mm), 0.5 to 6 N/mm.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "thickness": Size("m", 0.3e-3, 4e-3),
    "stiffness": Size("N/m", 500.0, 6000.0, default=2000.0, amplitude=False),
}


@compiled
def push(depth, thickness, stiffness):
    """Normal force (N) of a pad; depth (m): of the finger under it."""
    return stiffness * min(max(0.0, depth + thickness), thickness)
