"""Outside the catalogue: flexors that bend over the edge of their guides once a finger has closed.

    T_finger = T exp(-friction max(0, q - angle) tanh(v / v_s)),  v_s = 5 mm/s

T: on the cart's side; q: MCP angle; v: flexor taken up (m/s), positive closing. Below `angle` the
wire runs free of the edge. The cart still bears T. Source: Euler (1769), Eytelwein (1808), with a
wrap that the joint sets. Range: fibre on a polished mouth (0.05) to fibre in the groove that it has
cut into a printed one (0.9).
"""

from math import exp, tanh

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "friction": Size("1", 0.05, 0.9),
    "angle": Size("rad", 0.25, 0.45, default=0.3, amplitude=False),
}
SLIDE_SPEED = 5e-3  # m/s


@compiled
def passed(h, tension, angle, speed):
    """Tension (N) that reaches a finger at its MCP angle (rad), taking up flexor (m/s)."""
    wrap = angle - h.sheath_edge_angle
    if h.sheath_edge_friction == 0.0 or wrap <= 0.0:
        return tension
    return tension * exp(-h.sheath_edge_friction * wrap * tanh(speed / SLIDE_SPEED))
