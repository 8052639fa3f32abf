"""Outside the catalogue: a driver that lowers its current limit as it warms within a run.

    limit = position_pid.limit / (1 + fall E),  E' = i_measured^2,  E = 0 at the start of a run

E: heat of the bridge over its resistance, 1.3 A2 s in the paper's grasp, 0.1 in its free closure,
where nothing is limited. Only for the sampled controller. Source: I2t protection of motor drives
(data sheets). Range: 0.5 to 8 1/(A2 s): the limit of 4 A ends at 2.4 A, or at 0.4 A if the current
went on as before.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"fall": Size("1/(A^2 s)", 0.5, 8.0)}


@compiled
def limit(h, heat):
    """Largest current (A) that is asked for after a heat (A2 s)."""
    return h.position_pid_limit / (1.0 + h.thermal_derating_fall * heat)
