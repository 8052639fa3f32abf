"""Effects that a hand of the truth can hide: the catalogue's, written a second time, and others.

One file each, found by itself: equation, source, parameters (SIZES) and their physical range.
`python -m benchmarks.truth.effects` prints them as a table. SI units; motor, friction and load at
the motor's side; q closing positive; a size of 0 is exactly no effect. `T += ...` adds to the base
model's term of that name; way = tanh(w / motor.friction_speed). A parameter that is no amplitude
says where or how fast the effect acts, not how much of it there is; such a parameter has a
default.

Measured current passes lag, gain, offset, delay in this order; then noise and resolution. The
current sensor's effects reach the controller and the log.

Kinds outside the catalogue are OPENED or SEALED. Who improves a method looks at cases where it
fails, and so fits it to the kinds that those hide: a figure over such kinds says little of a kind
that nobody thought of. So cases of development hide opened kinds alone, and the run whose figures
are quoted is the first to hide sealed ones. They were written from what happens to such hands, by
somebody who had not read the method. A sealed kind whose outcome was used to change the method is
opened from then on, and another must be written.

An effect that adds to a quantity of `added.py` defines the function named there, and no other file
has to know of it. What acts elsewhere is called by the stage where it acts.
"""

import importlib
import pkgutil
from types import ModuleType

# No catalogue has these. Any case may hide the opened ones.
OPENED = ("friction_step", "nonlinear_spring", "eccentric_pulley", "jammed_finger", "wire_creep",
          "notched_joint", "stacked_wire", "error_dead_band", "force_saturation")  # fmt: skip
# Kinds that no development case may hide: only the run that is quoted does.
SEALED = ("striking_thumb", "sheath_edge", "jammed_cart", "damaged_tooth", "saturating_motor",
          "limited_supply", "thermal_derating", "encoder_eccentricity", "soft_pad",
          "clock_error")  # fmt: skip
_OUTSIDE = OPENED + SEALED


def _loaded(name: str) -> ModuleType:
    return importlib.import_module(f"{__name__}.{name}")


_KNOWN = [each.name for each in pkgutil.iter_modules(__path__) if not each.name.startswith("_")]
CATALOGUE = tuple(_loaded(name) for name in _KNOWN if name not in _OUTSIDE)
OUTSIDE = tuple(map(_loaded, _OUTSIDE))

# Full name, as in "leader_slack.length" -> its declaration.
SIZES = {
    f"{effect.__name__.rpartition('.')[2]}.{name}": size
    for effect in (*CATALOGUE, *OUTSIDE)
    for name, size in effect.SIZES.items()
}


def table() -> str:
    """Every parameter: unit, range, default where it is no amplitude; a line each."""
    width = max(map(len, SIZES))
    lines = []
    for name, size in SIZES.items():
        default = "" if size.amplitude else f"  (default {size.default:g})"
        lines.append(f"{name:<{width}}  {size.unit:<9}  {size.low:g} to {size.high:g}{default}")
    return "\n".join(lines)
