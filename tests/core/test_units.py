"""Values with a unit: what is read, what is refused, and the exact way back."""

import json
import math
import os
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hannes.core.errors import BadInput
from hannes.core.io import unit_factors
from hannes.core.io.units import quantity, text, unit_scale

UNITS = ["m", "N m/rad", "kg m2", "kg m^2", "A s/rad", "1", "V/(A s)", "ohm", "K", "degC", "rad/s"]


@pytest.mark.parametrize(
    ("given_text", "unit", "value"),
    [
        ("3.1 mm", "m", 0.0031),
        ("59 N s/m", "N s/m", 59.0),
        ("10 mA", "A", 0.01),
        ("1 kHz", "Hz", 1000.0),
        ("-9.81 m/s^2", "m/s^2", -9.81),
        ("-9.81 m/s²", "m/s2", -9.81),
        ("9.81 m/s/s", "m s^-2", 9.81),
        ("0.4", "1", 0.4),
        (0.4, "1", 0.4),
        (3, "1", 3.0),
        ("40 %", "1", 0.4),
        ("24.7 mN m/rad", "N m/rad", 0.0247),
        ("24.7 (mN*m)/rad", "N m/rad", 0.0247),
        ("4.2 g cm2", "kg m2", 4.2e-7),
        ("4.2 g·cm²", "kg m^2", 4.2e-7),
        ("5 mV/(A ms)", "V/(A s)", 5.0),
        ("600 mΩ", "ohm", 0.6),
        ("22 µm", "m", 22e-6),
        ("180 deg", "rad", math.pi),
        ("100 rpm", "rad/s", 100 * 2 * math.pi / 60),
        ("22 K", "K", 22.0),
        ("22 delta_degC", "K", 22.0),
        ("25 degC", "degC", 25.0),
        ("  1e-3m ", "m", 1e-3),
        ("0e999999999999 m", "m", 0.0),
        ("1e-999999999999 m", "m", 0.0),
        ("5 1/s", "1/s", 5.0),
    ],
)
def test_reads(given_text: object, unit: str, value: float) -> None:
    assert quantity(given_text, unit, "x") == value


@pytest.mark.parametrize(
    ("came", "unit"),
    [
        ("9.84", "rad"),
        ("9.84 1", "rad"),
        (9.84, "rad"),
        (3, "m"),
        ("30 deg", "m"),
        ("3 m", "rad"),
        ("16 Hz", "rad/s"),
        ("2 N m", "N m/rad"),
        ("25 degC", "K"),
        ("25 K", "degC"),
        ("1 degC/s", "K/s"),
        ("1 Fr", "1/s"),  # root units with half powers
        ("3 dB", "1"),
        ("0.4 N", "1"),
        ("nan m", "m"),
        ("inf m", "m"),
        ("1e400 m", "m"),
        ("1e308 km", "m"),
        (math.nan, "1"),
        (math.inf, "1"),
        (10**400, "1"),
        (True, "1"),
        (None, "m"),
        ([1], "m"),
        ({"a": {1}}, "m"),
        ("", "m"),
        ("m", "m"),
        ("1,5 mm", "m"),
        ("1.2.3 mm", "m"),
        ("1_000 mm", "m"),
        ("3 2 m", "m"),
        ("3 mm mm", "m"),
        ("3 metros", "m"),
        ("3 m^99999999", "m"),
        ("3 m^9^9^9", "m"),
        ("3 (m", "m"),
        ("3 m/", "m"),
        ("3 /m", "1/m"),
        ("1 N/m s", "N s/m"),
        ("3 m\n", "s"),
        ("1 __import__('os').getcwd()", "m"),
        ("3 " + "m " * 1000, "m"),
    ],
)
def test_refuses_in_one_line(came: object, unit: str) -> None:
    with pytest.raises(BadInput) as caught:
        quantity(came, unit, "part.value")
    message = str(caught.value)
    assert message.startswith("part.value = ") and "expected a" in message
    assert "\n" not in message and len(message) < 250


@pytest.mark.parametrize(
    ("came", "unit", "message"),
    [
        ("3 N", "m", '"3 N" is not a length: expected a value in m, such as "3.1 mm"'),
        (3.1, "m", '3.1 has no unit: expected a value in m, such as "3.1 mm"'),
        ("9.84", "rad", '"9.84" has no unit: expected a value in rad, such as "1.57 rad"'),
        ("1 N", "1", '"1 N" is not a plain number: expected a number, such as "0.4"'),
        ("3 foo", "s", '"3 foo" has the unknown unit "foo": expected a value in s, such as'),
        (
            "3 N",
            "V/(A s)",
            '"3 N" is not in V/(A s): expected a value in V/(A s), such as "0.5 V/(',
        ),
        ("1 kg", "kg m2", '"1 kg" is not a moment of inertia: expected a value in kg m2, such'),
    ],
)
def test_says_what_was_expected(came: object, unit: str, message: str) -> None:
    with pytest.raises(BadInput) as caught:
        quantity(came, unit, "leader_slack.length")
    assert str(caught.value).startswith(f"leader_slack.length = {message}")


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(UNITS))
def test_text_reads_back_to_the_same_float(value: float, unit: str) -> None:
    back = quantity(text(value, unit), unit, "x")
    assert back == value and math.copysign(1, back) == math.copysign(1, value)


@given(st.text(max_size=100), st.sampled_from(UNITS))
def test_any_text_is_a_finite_value_or_bad_input(came: str, unit: str) -> None:
    try:
        assert math.isfinite(quantity(came, unit, "x"))
    except BadInput as error:
        assert "\n" not in str(error)


@given(st.text("0123456789.e+-/()^*% mNsradVA_1", max_size=30), st.sampled_from(UNITS))
def test_unit_like_text_is_a_finite_value_or_bad_input(came: str, unit: str) -> None:
    try:
        assert math.isfinite(quantity(came, unit, "x"))
    except BadInput as error:
        assert "\n" not in str(error)


def test_every_example_in_a_message_is_itself_accepted() -> None:
    from hannes.core.io.units import _KINDS

    for unit, (_, example) in _KINDS.items():
        quantity(example, unit, unit)


def test_unit_scale() -> None:
    assert unit_scale("mm", "m") == 0.001
    assert unit_scale("m", "mm") == 1000.0
    assert unit_scale("1", "1") == 1.0
    with pytest.raises(BadInput, match="does not convert"):
        unit_scale("deg", "m")


def test_text_refuses_what_is_not_finite() -> None:
    with pytest.raises(BadInput, match="not finite"):
        text(math.nan, "m")


# --- what is kept -----------------------------------------------------------------------------

ASKED = """
import json, sys
from hannes.core.io.units import quantity
values = [quantity("3.1 mm", "m", "x"), quantity("25 degC", "degC", "x")]
print(json.dumps([values, "pint" in sys.modules]))
"""


def asked(folder):
    """Values in a process of its own, and whether pint was needed."""
    done = subprocess.run(
        [sys.executable, "-c", ASKED],
        env={**os.environ, "HANNES_CACHE": str(folder), "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


def test_what_a_unit_is_worth_is_asked_of_pint_once(tmp_path, monkeypatch):
    values = [0.0031, 25.0]
    assert asked(tmp_path) == [values, True]
    assert asked(tmp_path) == [values, False]
    (kept,) = (tmp_path / "hannes").glob("units_*.json")
    with monkeypatch.context() as patch:
        patch.setattr(unit_factors, "_path", lambda: kept)
        assert unit_factors._kept.__wrapped__()
        for damaged in ("", "{", "[1, 2]", '{"mm": ["x", []]}', '{"mm": 1}'):
            kept.write_text(damaged)
            assert unit_factors._kept.__wrapped__() == {}
    assert asked(tmp_path) == [values, True]  # and it is mended
    assert asked(tmp_path) == [values, False]


def test_units_work_where_nothing_can_be_kept(tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert asked(tmp_path / "file") == [[0.0031, 25.0], True]
