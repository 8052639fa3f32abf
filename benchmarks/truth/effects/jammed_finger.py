"""Outside the catalogue: a finger that jams before its end.

    closing stops of the finger's two joints at  q_end - lost (q_end - q_rest)

finger: 0 index to 4 thumb. Source: geometry. Range: 50 % to 95 % of the travel lost (on the
dynamometer a finger uses about a third of it).
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "lost": Size("1", 0.5, 0.95),
    "finger": Size("1", 0.0, 4.0, default=1.0, amplitude=False),
}


@compiled
def end(h, finger, rest, upper):
    """Angle (rad) of a joint's closing stop."""
    if finger != h.jammed_finger_finger:
        return upper
    return upper - h.jammed_finger_lost * (upper - rest)
