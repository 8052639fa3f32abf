"""Functions of math, numpy and Python: all lanes at once, or the C library's lane by lane."""

import ast
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from llvmlite import ir

from hannes.simulation.compiler.lanes.arithmetic import Arithmetic, lane_of
from hannes.simulation.compiler.lanes.values import REAL, TYPES, NotInLanes, Number

# All lanes at once, by LLVM's name; the C library's, lane by lane; of these what LLVM knows.
_IN_LANES = {"sqrt": "sqrt", "fabs": "fabs", "floor": "floor", "ceil": "ceil", "rint": "rint"}
_LANE_BY_LANE = {
    "exp",
    "log",
    "sin",
    "cos",
    "tan",
    "tanh",
    "atan",
    "pow",
    "log1p",
    "expm1",
    "nextafter",
}
_OF_LLVM = {"exp", "log", "sin", "cos", "pow"}


BUILTIN = {each.__name__: each for each in (abs, min, max, round, int, float, bool)}
_ALIASES = {
    "abs": "fabs", "absolute": "fabs", "arctan": "atan", "maximum": "max", "minimum": "min"
}  # fmt: skip
_KINDS = {"float": "real", "int": "whole", "bool": "truth"}


def of_library(function: Any) -> bool:
    """Whether it is a function of math, numpy or Python itself."""
    own = getattr(function, "__module__", "") == "math" or isinstance(function, np.ufunc)
    return own or function in BUILTIN.values()


class Library(Arithmetic):
    """Those of real numbers; numba's own choices where there are several."""

    def by_llvm(self, name: str, given: Sequence[Number]) -> Number:
        """An intrinsic function of real numbers, all lanes at once."""
        varying = any(a.varying for a in given)
        given = [self.as_kind(a, "real", varying) for a in given]
        kind = self.type_of("real", varying)
        short = f"v{self.width}f64" if varying else "f64"
        called = self.declared(f"llvm.{name}.{short}", kind, [kind] * len(given))
        return Number(self.builder.call(called, [a.ir for a in given]), "real", varying)

    def lane_by_lane(self, name: str, given: Sequence[Number]) -> Number:
        """The C library's function of each lane."""
        full = f"llvm.{name}.f64" if name in _OF_LLVM else name
        called = self.declared(full, REAL, [REAL] * len(given))
        if not any(a.varying for a in given):
            return Number(self.builder.call(called, [a.ir for a in given]), "real")
        given = [self.as_kind(a, "real", True) for a in given]
        made: ir.Value = ir.Constant(self.type_of("real", True), ir.Undefined)
        for lane in range(self.width):
            own = [self.builder.extract_element(a.ir, lane_of(lane)) for a in given]
            made = self.builder.insert_element(made, self.builder.call(called, own), lane_of(lane))
        return Number(made, "real", True)

    def library(self, name: str, given: Sequence[Number]) -> Number:
        """A function of math, numpy or Python itself."""
        name = _ALIASES.get(name, name)
        if name in ("max", "min"):
            return self.extreme(name, given)
        if name == "fabs" and given[0].kind != "real":
            raise NotInLanes("abs of a whole number")
        if len(given) == 1 and given[0].known is not None and hasattr(math, name):
            return self.known(getattr(math, name)(given[0].known))
        if name in _KINDS and len(given) == 1:
            return self.as_kind(given[0], _KINDS[name])
        if name == "round" and len(given) == 1:
            return self.as_kind(self.by_llvm("rint", given), "whole")
        if name == "isfinite":
            size = self.by_llvm("fabs", given)
            return self.compare(ast.Lt(), size, self.known(math.inf))
        if name == "copysign":
            return self.by_llvm("copysign", given)
        if name in _IN_LANES:
            return self.by_llvm(_IN_LANES[name], given)
        if name in _LANE_BY_LANE:
            return self.lane_by_lane(name, [self.as_kind(a, "real") for a in given])
        raise NotInLanes(name)

    def power_of_two(self, k: Number) -> Number:
        """2^k, see `power_of_two` in jit.py."""
        k = self.as_kind(k, "real")
        if k.known is not None:
            return self.known(2.0**k.known)
        build, to = self.builder, self.type_of("whole", k.varying)
        beside = build.fadd(k.ir, self._constant("real", 1.5 * 2.0**52, k.varying))
        raised = build.shl(build.bitcast(beside, to), self._constant("whole", 52, k.varying))
        power = build.add(raised, self._constant("whole", 1023 << 52, k.varying))
        return Number(build.bitcast(power, k.ir.type), "real", k.varying)

    def _constant(self, kind: str, value: float, varying: bool) -> ir.Value:
        one = ir.Constant(TYPES[kind], value)
        return self.spread(Number(one, kind)) if varying else one
