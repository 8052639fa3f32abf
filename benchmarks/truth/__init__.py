"""A second Hannes hand that shares nothing with the library: it checks it, and hides effects.

Where the library uses joint coordinates, a written-out mass matrix and scipy's solvers, this one
uses natural coordinates (the planar positions of each finger's PIP joint and tip) projected on the
joints, and a fixed-step, fully implicit SDIRK2 method. SI units everywhere.
"""

from benchmarks.truth.parameters import NOMINAL, nominal, read_hand
from benchmarks.truth.scatter import run_scatter, scatter
from benchmarks.truth.simulation import EFFECTS, QUIET, simulate, trace

__all__ = [
    "EFFECTS",
    "NOMINAL",
    "QUIET",
    "nominal",
    "read_hand",
    "run_scatter",
    "scatter",
    "simulate",
    "trace",
]
