"""A second Hannes hand that shares nothing with the library: it checks it, and hides effects.

Where the library uses joint coordinates, a written-out mass matrix and a linearly implicit method,
this one uses natural coordinates (the planar positions of each finger's PIP joint and tip)
projected on the joints, and TR-BDF2 with Newton's method on speeds and current alone. SI units.
"""

from benchmarks.truth.parameters import NOMINAL, nominal
from benchmarks.truth.simulation import simulate, trace

__all__ = ["NOMINAL", "nominal", "simulate", "trace"]
