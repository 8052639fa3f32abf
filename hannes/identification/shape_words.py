"""What a reader is given of the shape of what is missing: sentences, and a caution."""

from collections.abc import Mapping
from typing import Any

NO_CAUSE = "this describes what is missing and is not its cause"


def shape_sentence(shape: Mapping[str, Any]) -> str:
    """What generic disturbance follows the recordings, or that none does; empty without a shape."""
    if not shape:
        return ""
    if not shape["name"]:
        return f"No generic disturbance describes it: {shape['why_not']}."
    return f"Likeliest shape: {shape['meaning']}. {_tested(shape)}; {NO_CAUSE}."


def _tested(shape: Mapping[str, Any]) -> str:
    """What recordings that were not fitted say of it."""
    if shape["shown"]:
        closes = f"{100.0 * shape['closes']:.0f} %"
        return f"On recordings that were not fitted it closes {closes} of the reducible gap"
    explains = f"{100.0 * shape['explains']:.0f} %"
    return (
        f"It explains {explains} of the misfit; recordings that were not fitted cannot show it, "
        "as it changes them by less than runs may differ by"
    )


def description_caution(verdict: str, shape: Mapping[str, Any]) -> str:
    """What a hand.toml holds where a description was asked for, by the verdict and its shape."""
    if name := shape.get("name"):
        return f"hand.toml has {name}, a law of free shape, where nothing can be named: {NO_CAUSE}"
    if verdict != "unknown":
        return f"nothing is to be described: the verdict is {verdict}"
    if not shape:
        return (
            "no generic disturbance was fitted: the search was ended, the plant declares nothing "
            "uncertain, or none fits it; hand.toml is as without --describe"
        )
    return "no generic disturbance describes what is missing: hand.toml is as without --describe"
