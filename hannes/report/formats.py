"""Numbers as people read them."""

import math

_MINUS = "\N{MINUS SIGN}"


def number(value: float, digits: int = 3) -> str:
    """`digits` significant digits with a true minus sign; an en dash where there is no value."""
    if not math.isfinite(value):
        return "\N{EN DASH}"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e5:
        return power(value, digits)
    places = max(0, digits - 1 - _exponent(value)) if value else 0
    return f"{value:.{places}f}".replace("-", _MINUS)


def decimals(value: float, places: int) -> str:
    """A fixed number of decimals with a true minus sign."""
    text = f"{value:.{places}f}" if math.isfinite(value) else "\N{EN DASH}"
    return text.replace("-", _MINUS)


def signed(value: float, places: int = 1) -> str:
    """Fixed decimals, always with a sign; zero has none."""
    rounded = round(value, places) + 0.0
    return ("+" if rounded > 0 else "") + decimals(rounded, places)


def power(value: float, digits: int = 2) -> str:
    """As 1.4 · 10⁻²; a pure power of ten as 10⁻²."""
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    raised = "10" + str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    if float(mantissa) == 1.0:
        return raised
    return f"{mantissa} · {raised}".replace("-", _MINUS)


def _exponent(value: float) -> int:
    return math.floor(math.log10(abs(value)))
