"""Elementary functions of loops over joints: as exact as declared, compiled and plain."""

import math
from fractions import Fraction

import numpy as np
import pytest

from hannes.core.kernels.jit import fused, kernel, plain, power_of_two
from hannes.core.kernels.vector_math import direction, exp_minus_one, soft_sign

RANDOM = np.random.default_rng(3)
SIZES = 10.0 ** RANDOM.uniform(-12.0, 1.5, 400)
ANGLES = np.concatenate([RANDOM.uniform(-40.0, 40.0, 400), SIZES])
FORMS = pytest.mark.parametrize("form", [plain, lambda function: function])


@FORMS
def test_exponential_less_one(form):
    for x in (*SIZES, *-SIZES, 690.0, -690.0, 0.5 * math.log(2.0)):
        assert form(exp_minus_one)(x) == pytest.approx(math.expm1(x), rel=1e-15, abs=0.0)
    assert form(exp_minus_one)(0.0) == 0.0
    assert math.isnan(form(exp_minus_one)(math.nan))


@FORMS
def test_hyperbolic_tangent(form):
    exact = np.array([math.tanh(x) for x in SIZES])
    for sign in (1.0, -1.0):
        assert np.abs([form(soft_sign)(sign * x) for x in SIZES] / exact - sign).max() < 1e-15


@FORMS
def test_cosine_and_sine(form):
    found = np.array([form(direction)(x) for x in ANGLES])
    exact = np.array([(math.cos(x), math.sin(x)) for x in ANGLES])
    assert np.abs(found - exact).max() < 8e-15  # of 2 pi, rounded, times as many turns
    near = np.abs(ANGLES) < math.pi
    assert np.abs(found - exact)[near].max() < 1e-15


@kernel
def powers(whole, found):
    for i in range(whole.size):
        found[i] = power_of_two(whole[i])


def test_powers_of_two_are_exact():
    whole = np.arange(-1022.0, 1024.0)
    found = np.empty(whole.size)
    powers(whole, found)
    assert (found == 2.0**whole).all()
    assert [plain(power_of_two)(k) for k in whole] == found.tolist()


@kernel
def in_loop(a, b, c, found):
    for i in range(a.size):
        found[i] = fused(a[i], b[i], c[i])


@FORMS
@pytest.mark.parametrize("angle", [0, True, np.float32(0.5)])
def test_whole_and_short_numbers_are_taken_too(form, angle):
    assert form(direction)(angle) == pytest.approx((math.cos(angle), math.sin(angle)), abs=1e-7)


def test_a_fused_sum_is_rounded_once_wherever_it_stands(compiling):
    a, b = RANDOM.standard_normal((2, 101))
    c = -a * b * (1.0 + 1e-14 * RANDOM.standard_normal(101))  # all but cancels
    found = np.empty(101)
    in_loop(a, b, c, found)
    exact = [
        float(Fraction(x) * Fraction(y) + Fraction(z)) for x, y, z in zip(a, b, c, strict=True)
    ]
    assert (found == exact).all()
    assert (found != a * b + c).any()
