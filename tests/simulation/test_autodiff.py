"""Derivatives that are written out against central differences, kernel by kernel."""

import math

import numpy as np
import pytest
from catalogued import CATALOGUE

from hannes.core.kernels.jit import kernel, plain
from hannes.core.kernels.smooth_switches import limited, one_sided
from hannes.core.kernels.vector_math import direction, exp_minus_one, soft_sign
from hannes.simulation.compiler.autodiff.dead_code import without_dead_code
from hannes.simulation.compiler.autodiff.forward import Differentiation
from hannes.simulation.compiler.autodiff.rules import LANES
from hannes.simulation.compiler.autodiff.values import NotDifferentiable, Value
from hannes.simulation.hand.jacobian.drivetrain_block import WRITTEN

STEP = 1e-6


def differentiated(function, count, written=WRITTEN):
    """Lines that compute a kernel and its derivatives by all its arguments, and their names."""
    found = Differentiation({}, {"f": function}, written)
    result = found.kernel("f", [Value(f"x[{n}]", {n: "1.0"}) for n in range(count)])
    return found.lines, result if isinstance(result, tuple) else (result,)


def jacobian(function, x, written=WRITTEN):
    """Values and derivatives of a kernel as the lines have them."""
    lines, values = differentiated(function, len(x), written)
    space = {"x": x, "math": math, "np": np, "f": function, **LANES}
    exec("\n".join(lines), space)
    rows = [[eval(each.derivatives.get(n, "0.0"), space) for n in range(len(x))] for each in values]
    return [eval(each.text, space) for each in values], np.array(rows)


def central(function, x):
    """Derivatives by central differences."""
    columns = []
    for n in range(len(x)):
        step = STEP * max(abs(x[n]), 1e-2)
        ends = [np.ravel(function(*x[:n], x[n] + d, *x[n + 1 :])) for d in (step, -step)]
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.array(columns).T


def agree(function, x, written=WRITTEN):
    """Compare both."""
    values, mine = jacobian(function, x, written)
    theirs = central(function, x)
    assert np.allclose(values, np.ravel(function(*x)), rtol=1e-12, atol=0.0)
    scale = np.abs(theirs).max() + 1e-12
    assert np.abs(mine - theirs).max() < 1e-6 * scale, (x, mine, theirs)


KERNELS = {
    f"{effect.name}.{plain(term.kernel).__name__}": term.kernel
    for effect in CATALOGUE.values()
    for term in effect.terms
}


@pytest.mark.parametrize("name", KERNELS)
def test_every_kernel_of_the_catalogue_is_derived(name):
    function, rng = plain(KERNELS[name]), np.random.default_rng(3)
    count = function.__code__.co_argcount
    assert not any("f(" in line for line in differentiated(function, count)[0])
    for _ in range(50):
        agree(function, list(rng.uniform(0.2, 1.5, count) * rng.choice([-1.0, 1.0], count)))


def rational(a, b, c):
    """Every operation, with a loop, a branch that returns and one that does not."""
    total = 0.0
    for k in range(3):
        total += (k + 1) * a / (b + k)
    if c > 1.0:
        total -= b**2 * c
    else:
        total = -total + 3.0
    if total < -100.0:
        return total
    return total * abs(c) ** 1.5 + min(a, b, 0.3) * max(b, c) + 2.0**a


def transcendental(a, b, c):
    """Every function."""
    root = math.sqrt(a * a + b * b)
    wave = math.sin(a) * np.cos(b) + math.tan(0.1 * c) + math.atan(c)
    rise = np.exp(-root) + math.log(1.0 + root) + math.tanh(a * c)
    return wave * rise + math.copysign(root, c), wave if a > b else rise + np.abs(c)


def searching(a, b, c):
    """A loop that ends by what it finds."""
    x = abs(a) + 1.0
    while x > 0.5:
        x *= 0.5
    return x * b + c


@pytest.mark.parametrize(
    "function",
    [
        rational,
        transcendental,
        plain(limited),
        plain(direction),
        plain(soft_sign),
        plain(exp_minus_one),
    ],
)
@pytest.mark.parametrize("written", [{}, WRITTEN])
def test_operations_functions_and_branches(function, written):
    rng, count = np.random.default_rng(4), function.__code__.co_argcount
    for _ in range(50):
        agree(function, list(rng.normal(size=count)), written)


def test_written_derivatives_are_taken_at_a_kink():
    just_slack = [2.0, 0.1, -1e-6, 0.5, 1.0]
    function = plain(one_sided)
    assert jacobian(function, just_slack, {})[1][0, 2] == 0.0
    found = Differentiation({}, {"f": function}, WRITTEN)
    given = [Value(f"x[{n}]", {n: "1.0"} if n in (2, 3) else {}) for n in range(5)]
    value = found.kernel("f", given)
    space = {"x": just_slack, "math": math, "np": np}
    exec("\n".join(found.lines), space)
    assert eval(value.derivatives[2], space) == 2.0  # of the side that pushes, 1e-4 onset before it


def test_what_cannot_be_derived_is_differenced():
    lines, _ = differentiated(searching, 3)
    assert sum("f(" in line for line in lines) == 4  # as it is, and with each argument moved
    x = [0.3, -0.7, 1.1]
    assert np.abs(jacobian(searching, x)[1] - central(searching, x)).max() < 1e-6


@kernel
def refusing(a):
    """Derived in its first branch, not in the second."""
    if a > 0.0:
        return 2.0 * a
    return sum([a, a, a])


def test_a_derivation_that_fails_leaves_nothing_behind():
    lines, _ = differentiated(plain(refusing), 1)
    assert len([line for line in lines if "f(" in line]) == 2
    assert not any(line.startswith("if") for line in lines)


def test_arrays_that_are_derived_by_cannot_be_handed_on():
    def reads(y):
        return sum(y)

    from hannes.simulation.compiler.autodiff.values import Array

    found = Differentiation({}, {"f": reads}, {})
    found.store["y", 0] = Value("y[0]", {0: "1.0"})
    with pytest.raises(NotDifferentiable, match="all of y"):
        found.kernel("f", [Array("y")])


def test_lines_that_nothing_needs_are_dropped():
    lines = ["v1 = a", "v2 = v1", "if v1 > 0.0:", "    v3 = v2", "else:", "    v3 = 0.0", "v4 = v3"]
    assert without_dead_code(lines) == []
    assert without_dead_code([*lines, "out[0] = v1"]) == ["v1 = a", "out[0] = v1"]
    half = ["if a:", "    v1 = b", "else:", "    v2 = b", "x[0] = v2"]
    assert without_dead_code(half) == ["if a:", "    pass", "else:", "    v2 = b", "x[0] = v2"]
