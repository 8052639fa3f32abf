"""Leader-wire slack: loose wire that must be wound up before anything moves.

    s_L = r_p phi - length - (2 x_A + 2 x_B + l_thumb)

s_L: stretch of the leader (m); phi: output-shaft angle; x: carts; l: flexor taken up.
Source: the paper's discussion of Fig. 7. Range: from a relaxed knot (0.2 mm) to a wire that has
slipped half a turn on its pulley (8 mm).
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"length": Size("m", 0.2e-3, 8e-3)}


@compiled
def loose(h):
    """Free length of the leader (m)."""
    return h.leader_slack_length
