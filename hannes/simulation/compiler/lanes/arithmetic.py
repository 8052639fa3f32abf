"""Arithmetic over numbers that are the same in all lanes or differ."""

import ast
import functools
import math
import operator
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

from llvmlite import ir

from hannes.simulation.compiler.autodiff.rules import OPERATORS
from hannes.simulation.compiler.lanes.values import REAL, TYPES, NotInLanes, Number, wider

_KNOWN = {kind: computed for kind, (_, computed) in OPERATORS.items()}
_REAL = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_WHOLE = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}
_SIGNS = {
    ast.Lt: ("<", operator.lt),
    ast.LtE: ("<=", operator.le),
    ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge),
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
}
NO_USE = 0x3 | 0x204 | 0x60  # of LLVM's classes: no number, infinite, zero


class Arithmetic(ABC):
    """Instructions for `width` lanes, put where `builder` stands."""

    def __init__(self, module: ir.Module, width: int) -> None:
        self.module, self.width = module, width
        self.builder: ir.IRBuilder = ir.IRBuilder()
        self.reciprocals: dict[Any, ir.Value] = {}

    @abstractmethod
    def lane_by_lane(self, name: str, given: Sequence[Number]) -> Number:
        """A function of the C library of each lane."""

    def type_of(self, kind: str, varying: bool) -> ir.Type:
        """Type of such a number."""
        return ir.VectorType(TYPES[kind], self.width) if varying else TYPES[kind]

    def known(self, value: Any) -> Number:
        """A number that is known."""
        if isinstance(value, bool):
            return Number(ir.Constant(TYPES["truth"], int(value)), "truth", False, value)
        if isinstance(value, int):
            return Number(ir.Constant(TYPES["whole"], value), "whole", False, value)
        return Number(ir.Constant(REAL, float(value)), "real", False, float(value))

    def as_kind(self, a: Number, kind: str, varying: bool = False) -> Number:
        """The same number as another kind, in all lanes where asked."""
        if a.known is not None and a.kind != kind:
            a = self.known({"real": float, "whole": int, "truth": bool}[kind](a.known))
        elif a.kind != kind:
            to = self.type_of(kind, a.varying)
            if kind == "real":
                made = self.builder.sitofp if a.kind == "whole" else self.builder.uitofp
                a = Number(made(a.ir, to), kind, a.varying)
            elif kind == "whole" and a.kind == "truth":
                a = Number(self.builder.zext(a.ir, to), kind, a.varying)
            elif kind == "whole":
                a = Number(self.builder.fptosi(a.ir, to), kind, a.varying)
            else:
                a = self.compare(ast.NotEq(), a, self.known(0))
        if varying and not a.varying:
            a = Number(self.spread(a), kind, True)
        return a

    def spread(self, a: Number) -> ir.Value:
        """A number in all lanes."""
        to = self.type_of(a.kind, True)
        if isinstance(a.ir, ir.Constant):
            return ir.Constant(to, [a.ir.constant] * self.width)
        first = self.builder.insert_element(ir.Constant(to, ir.Undefined), a.ir, lane_of(0))
        none = ir.Constant(ir.VectorType(ir.IntType(32), self.width), None)
        return self.builder.shuffle_vector(first, ir.Constant(to, ir.Undefined), none)

    def alike(self, *each: Number, least: str = "truth") -> list[Number]:
        """The same numbers as one kind."""
        kind = wider(least, *(a.kind for a in each))
        varying = any(a.varying for a in each)
        return [self.as_kind(a, kind, varying) for a in each]

    def binary(self, how: ast.operator, a: Number, b: Number) -> Number:
        """One number by another."""
        if a.known is not None and b.known is not None:
            return self.known(_KNOWN[type(how)](a.known, b.known))
        if isinstance(how, ast.Pow):
            return self._power(a, b)
        x, y = self.alike(a, b, least="real" if isinstance(how, ast.Div) else "whole")
        if isinstance(how, ast.Div) and x.varying:
            return self._divided(a, b, x, y)
        names = _REAL if x.kind == "real" else _WHOLE
        if type(how) in names:
            made = getattr(self.builder, names[type(how)])(x.ir, y.ir)
            return Number(made, x.kind, x.varying)
        if x.kind == "whole" and isinstance(how, ast.FloorDiv | ast.Mod):
            return self._floored(how, x, y)
        raise NotInLanes(type(how).__name__)

    def _divided(self, a: Number, b: Number, x: Number, y: Number) -> Number:
        """In all lanes: wide registers divide slower than all else, so by reciprocals."""
        if b.known is not None:
            per = self.known(1.0 / b.known)
            if math.frexp(b.known)[0] == 0.5:  # of a power of two
                return Number(self.builder.fmul(x.ir, self.spread(per)), "real", True)
            return self.quotient(x, y, self.spread(per))
        own = None
        if b.over is not None:
            own = self.builder.load(b.over, typ=self.type_of("real", b.varying))
            own = own if b.varying else self.spread(Number(own, "real"))
        if a.known == 1.0:
            return Number(own or self.reciprocal(y), "real", True)
        return self.quotient(x, y, own or self.reciprocal(y))

    def reciprocal(self, b: Number) -> ir.Value:
        """1 / b, computed once where several are divided by it."""
        place = self.builder.block, b.ir
        if place not in self.reciprocals:
            one = self.spread(self.known(1.0))
            self.reciprocals[place] = self.builder.fdiv(one, b.ir)
        return self.reciprocals[place]

    def quotient(self, a: Number, b: Number, per: ir.Value) -> Number:
        """a / b by the rounded reciprocal of b: rounded as a division is (Markstein 1990).

        Where b or the quotient is 0 or infinite the product is right as it is. That holds for
        |a| and |b| above 1e-290; below, the last digit may differ, and that of a denormal b, whose
        reciprocal is infinite, may be infinite or no number. No quantity of a hand is so small.
        """
        build = self.builder
        about = build.fmul(a.ir, per)
        fused = self.declared(f"llvm.fma.v{self.width}f64", per.type, [per.type] * 3)
        rest = build.call(fused, [build.fneg(b.ir), about, a.ir])
        better = build.call(fused, [rest, per, about])
        return Number(build.select(self._of_no_use(rest), about, better), "real", True)

    def _of_no_use(self, rest: ir.Value) -> ir.Value:
        """Whether it is 0, infinite or no number: in one instruction, where there is one."""
        build = self.builder
        if self.width == 8:
            truths = ir.VectorType(TYPES["truth"], self.width)
            kind = ir.IntType(32)
            known = self.declared("llvm.is.fpclass.v8f64", truths, [rest.type, kind])
            return build.call(known, [rest, kind(NO_USE)])
        none = ir.Constant(rest.type, None)
        nor = build.fsub(rest, rest)  # of infinity no number
        return build.or_(
            build.fcmp_unordered("==", rest, none), build.fcmp_unordered("uno", nor, nor)
        )

    def _floored(self, how: ast.operator, x: Number, y: Number) -> Number:
        """Of whole numbers, rounded down."""
        build = self.builder
        quotient, rest = build.sdiv(x.ir, y.ir), build.srem(x.ir, y.ir)
        none = ir.Constant(rest.type, None)
        apart = build.icmp_signed("<", build.xor(rest, y.ir), none)
        less = build.and_(apart, build.icmp_signed("!=", rest, none))
        if isinstance(how, ast.FloorDiv):
            made = build.sub(quotient, build.zext(less, quotient.type))
        else:
            made = build.add(rest, build.select(less, y.ir, none))
        return Number(made, "whole", x.varying)

    def _power(self, a: Number, b: Number) -> Number:
        if b.kind == "whole" and b.known is not None and b.known >= 0:
            return self._whole_power(a, int(b.known))
        if b.known is not None and a.kind == "real" and b.kind == "whole":
            return self.binary(ast.Div(), self.known(1.0), self._whole_power(a, -int(b.known)))
        return self.lane_by_lane("pow", [self.as_kind(a, "real"), self.as_kind(b, "real")])

    def _whole_power(self, a: Number, power: int) -> Number:
        """By squares, as numba does."""
        result = self.known(1.0 if a.kind == "real" else 1)
        first = True
        while power != 0:
            if power & 1:
                result = a if first else self.binary(ast.Mult(), result, a)
                first = False
            power >>= 1
            if power:
                a = self.binary(ast.Mult(), a, a)
        return result

    def minus(self, a: Number) -> Number:
        """Its negative."""
        if a.known is not None:
            return self.known(-a.known)
        if a.kind == "real":
            return Number(self.builder.fneg(a.ir), "real", a.varying)
        a = self.as_kind(a, "whole")
        return Number(self.builder.neg(a.ir), "whole", a.varying)

    def compare(self, how: ast.cmpop, a: Number, b: Number) -> Number:
        """A truth."""
        sign, computed = _SIGNS[type(how)]
        if a.known is not None and b.known is not None:
            return self.known(bool(computed(a.known, b.known)))
        x, y = self.alike(a, b, least="whole")
        if x.kind == "whole":
            made = self.builder.icmp_signed(sign, x.ir, y.ir)
        elif sign == "!=":
            made = self.builder.fcmp_unordered(sign, x.ir, y.ir)
        else:
            made = self.builder.fcmp_ordered(sign, x.ir, y.ir)
        return Number(made, "truth", x.varying)

    def joined(self, how: ast.boolop, a: Number, b: Number) -> Number:
        """Of two truths."""
        for one, other in ((a, b), (b, a)):
            if one.known is not None:
                return one if bool(one.known) == isinstance(how, ast.Or) else other
        x, y = self.alike(a, b)
        made = self.builder.or_ if isinstance(how, ast.Or) else self.builder.and_
        return Number(made(x.ir, y.ir), "truth", x.varying)

    def opposite(self, a: Number) -> Number:
        """Not."""
        a = self.as_kind(a, "truth")
        if a.known is not None:
            return self.known(not a.known)
        return Number(self.builder.not_(a.ir), "truth", a.varying)

    def any_of(self, a: Number) -> Number:
        """Whether it is true of any lane."""
        if not a.varying:
            return a
        bits = self.builder.bitcast(a.ir, ir.IntType(self.width))
        return Number(self.builder.icmp_unsigned("!=", bits, bits.type(0)), "truth")

    def select(self, truth: Number, a: Any, b: Any) -> Any:
        """Lane by lane the one or the other."""
        if a is b:
            return a
        if isinstance(a, tuple) and isinstance(b, tuple) and len(a) == len(b):
            return tuple(self.select(truth, *pair) for pair in zip(a, b, strict=True))
        if not isinstance(a, Number) or not isinstance(b, Number):
            if a == b:
                return a
            raise NotInLanes("one thing here, another there")
        if a.known is not None and a.known == b.known and a.kind == b.kind:
            if math.copysign(1.0, a.known) == math.copysign(1.0, b.known):
                return a
        x, y = self.alike(a, b)
        if truth.varying:
            x, y = self.as_kind(x, x.kind, True), self.as_kind(y, y.kind, True)
        return Number(self.builder.select(truth.ir, x.ir, y.ir), x.kind, x.varying)

    def extreme(self, name: str, given: Sequence[Number]) -> Number:
        """Least or largest, of equals the first, as numba does."""
        how = ast.Gt() if name == "max" else ast.Lt()
        if all(a.known is not None for a in given):
            return self.known((max if name == "max" else min)(a.known or 0 for a in given))
        return functools.reduce(lambda a, b: self.select(self.compare(how, b, a), b, a), given)

    def declared(self, name: str, result: ir.Type, given: Sequence[ir.Type]) -> ir.Function:
        """A function from elsewhere."""
        found = self.module.globals.get(name)
        return found or ir.Function(self.module, ir.FunctionType(result, given), name)


def lane_of(lane: int) -> ir.Constant:
    """A place in a vector."""
    return ir.Constant(ir.IntType(32), lane)
