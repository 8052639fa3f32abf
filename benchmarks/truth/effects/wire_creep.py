"""Outside the catalogue: a leader wire that lengthens under load and keeps it from run to run.

    slack' = rate T_L,  carried over the runs of a campaign in their order

Source: secondary creep of polyethylene fibre, linear in load. Range: 1e-7 to 1e-5 m/(N s): a dozen
grasps then leave 0.05 to 5 mm.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"rate": Size("m/(N s)", 1e-7, 1e-5)}


@compiled
def speed(h, tension):
    """Rate (m/s) at which the leader lengthens under its tension (N)."""
    return h.wire_creep_rate * tension
