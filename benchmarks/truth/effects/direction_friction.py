"""Direction-dependent friction: motor and gear rub harder one way than the other.

    T_friction = T_dry (1 + dry) closing, T_dry (1 - dry) opening
               + f |w| (1 + viscous) closing, (1 - viscous) opening

T_dry: `motor.dry_friction`; f: `motor.viscous_friction`. Each side smooths the transition through
standstill as it likes; here the share goes with tanh(w / w_s).
Source: Janot, Gautier & Brunot (2019), asymmetric friction of a screw drive. Range: 1 % to 40 % of
either part, both signs.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"dry": Size("1", -0.4, 0.4), "viscous": Size("1", -0.4, 0.4)}


@compiled
def shares(h, way):
    """Factors of dry and viscous friction; way: -1 opening to 1 closing."""
    return 1.0 + h.direction_friction_dry * way, 1.0 + h.direction_friction_viscous * way
