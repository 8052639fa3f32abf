"""Text for several lanes at once: each lane has the bits that the text gives alone."""

import ctypes
import math

import numpy as np
import pytest
from llvmlite import ir

from hannes.core.kernels.jit import power_of_two
from hannes.simulation.compiler.autodiff.values import tree
from hannes.simulation.compiler.lanes import machine
from hannes.simulation.compiler.lanes.emitter import Emitter
from hannes.simulation.compiler.lanes.kernels import aligned
from hannes.simulation.compiler.lanes.values import NotInLanes, Text

COUNT = 8
SPECIAL = np.array([0.0, -0.0, 1.0, -2.5, 3e-300, -1e300, math.inf, math.nan])
PLAIN = np.array([0.3, -0.7, 1.0, -2.5, 0.0, 4.0, 9.0, 1e-3])
TABLE = np.array([3.0, 1.0, 4.0, 1.5, 9.0])


def number(kind, known=None):
    return ("number", kind, False, known)


def column(size):
    return ("array", (number("whole", size),), (number("whole", 1),), "real", True, 0)


def asked(x, y):
    """In its place stands the function of a test, see `in_lanes`."""
    return x + y


def entry(given, found):
    """What is compiled."""
    found[0] = asked(given[0], given[1])
    return 0


def in_lanes(function, x, y, width=COUNT):
    """Value of a function of two numbers for each lane."""
    text = Text(tree(entry), {"asked": function})
    module, pointer = ir.Module(), ir.PointerType()
    Emitter(module, width, {}).written(text, [column(2), column(1)], [pointer] * 2, "entry")
    code = machine.Loaded(machine._compiled(module))
    run = code.function("entry", (ctypes.c_void_p, ctypes.c_void_p))
    found = []
    for start in range(0, COUNT, width):
        given, result = aligned(2 * width), aligned(width)
        given.reshape(2, width)[:] = x[start : start + width], y[start : start + width]
        run(given.ctypes.data, result.ctypes.data)
        found += result.tolist()
    return np.array(found)


def divided(x, y):
    return x / y


def by_thirds(x, y):
    return x / 3.0 - y / 0.125


def least(x, y):
    return min(max(x, y), 1.0)


def returns_early(x, y):
    if x <= 0.0:
        return 0.0
    if y > 0.5 and x < 2.0:
        return math.copysign(x, -y)
    return x * y


def newton(x, y):
    """A root, in as many turns as each lane needs."""
    root = 1.0 + abs(y)
    for _ in range(40):
        step = (root * root - abs(x)) / (2.0 * root)
        root -= step
        if abs(step) < 1e-9:
            break
    return root


def by_halves(x, y):
    turns, size = 0, abs(x)
    while size > 0.01:
        size = 0.5 * size
        turns += 1
    return turns + size * y


def counted(x, y):
    """Whole numbers that become real ones, and tuples carried on."""
    hits, pair = 0, (0.0, 1.0)
    for k in range(6):
        hits += x * k > y
        pair = (pair[1], pair[0] + x) if hits % 2 == 1 else (pair[0] - 1.0, pair[1])
    return 10.0 * hits + pair[0] - pair[1]


def looked_up(x, y):
    """A table's place that differs from lane to lane, found by halves."""
    low, high = 0, TABLE.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if middle <= 2.0 * x:
            low = middle
        else:
            high = middle
    return TABLE[low] + y * TABLE[high]


def nested(x, y):
    a, b = x, 0.0
    if x > 0.0:
        if y > 0.0:
            b = x + y
        else:
            a = newton(x, y)
    elif not y < -1.0:
        a, b = b, a
    return a - 2.0 * b


def elementary(x, y):
    z = math.exp(-x * x) + math.sin(y) * math.cos(x) + math.sqrt(abs(x)) + math.floor(2.0 * y)
    return z + abs(x) ** 1.5 + y**3 + round(x) + power_of_two(3.0)


EACH = (divided, by_thirds, least, returns_early, newton, by_halves, counted, looked_up, nested)


@pytest.mark.parametrize("function", EACH, ids=lambda each: each.__name__)
@pytest.mark.parametrize("width", [2, 8])
def test_lanes_have_the_bits_of_plain_text(function, width):
    others = np.roll(PLAIN, 3) + 0.25
    expected = [float(function(x, y)) for x, y in zip(PLAIN, others, strict=True)]
    found = in_lanes(function, PLAIN, others, width)
    assert np.array_equal(found, expected) and np.array_equal(
        np.signbit(found), np.signbit(expected)
    )


def test_elementary_functions_are_those_of_the_c_library():
    expected = [elementary(float(x), float(y)) for x, y in zip(PLAIN, PLAIN[::-1], strict=True)]
    assert in_lanes(elementary, PLAIN, PLAIN[::-1]) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("shift", range(1, COUNT))
def test_what_is_zero_or_infinite_or_no_number_is_divided_as_alone(shift):
    others = np.roll(SPECIAL, shift)
    with np.errstate(all="ignore"):
        expected = SPECIAL / others
    found = in_lanes(divided, SPECIAL, others)
    assert np.array_equal(found, expected, equal_nan=True)
    known = ~np.isnan(expected)
    assert np.array_equal(np.signbit(found[known]), np.signbit(expected[known]))


def test_a_million_quotients_are_rounded_as_divisions_are():
    rng = np.random.default_rng(2)
    text = Text(tree(many_entry), {})
    module, pointer = ir.Module(), ir.PointerType()
    row = column(None)
    keys = [row, row, row, number("whole")]
    Emitter(module, COUNT, {}).written(
        text, keys, [pointer, ir.IntType(64)] * 3 + [ir.IntType(64)], "entry"
    )
    code = machine.Loaded(machine._compiled(module))
    at, whole = ctypes.c_void_p, ctypes.c_int64
    run = code.function("entry", (at, whole, at, whole, at, whole, whole))
    size = 1_000_000
    x, y, found = aligned(size), aligned(size), aligned(size)
    x[:], y[:] = (rng.normal(size=size) * 10.0 ** rng.uniform(-20, 20, size) for _ in range(2))
    n = size // COUNT
    run(x.ctypes.data, n, y.ctypes.data, n, found.ctypes.data, n, n)
    assert np.array_equal(found, x / y)


def many_entry(x, y, found, count):
    """Quotients of rows."""
    for k in range(count):
        found[k] = x[k] / y[k]
    return count


def remembered(x, y):
    return [x, y][0]


def either(x, y):
    return x or y


def steps_of_its_own(x, y):
    total = 0.0
    for _ in range(int(x)):
        total += y
    return total


@pytest.mark.parametrize("function", [remembered, either, steps_of_its_own])
def test_what_is_not_known_is_refused(function):
    with pytest.raises(NotInLanes):
        in_lanes(function, PLAIN, PLAIN)
