"""A viscoelastic object: it creeps under load and recovers after it (standard linear solid).

    F_n = k (x - d) + beta x' ramp(x),  d' = (share max(0, x - d) - d) / time,  d = 0 at the start

x: depth; d: dent of each phalanx that has crept; held for long, the depth grows by `share`.
Source: Zener (1948), a spring in series with a Kelvin-Voigt element. Range: hard rubber (5 %) to
memory foam (150 %), 20 ms to 2 s.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.laws import held
from benchmarks.truth.size import Size

SIZES = {
    "share": Size("1", 0.05, 1.5),
    "time": Size("s", 0.02, 2.0, default=0.15, amplitude=False),
}


@compiled
def dent(start, gain, depth, share, time):
    """Dent d (m) after an implicit part-step from `start`, and a, b of its rate a - b d.

    depth: of the phalanx (m), below 0 where it is off the object.
    """
    a, b = share * depth / time, (1.0 + share) / time
    pressed = held(start, gain, a, b)
    if pressed <= depth:
        return pressed, a, b
    return held(start, gain, 0.0, 1.0 / time), 0.0, 1.0 / time
