"""Resolved TOML text of an experiment, as recordings carry it; reading it back gives the same."""

from collections.abc import Mapping
from typing import Any

from hannes.core.io.units import text
from hannes.core.model import differences
from hannes.simulation.experiment.experiment import Experiment, Reference, Target
from hannes.simulation.experiment.reader import MATERIAL, NOISE
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import effect_names, texts

TILT = ("tilt_x", "tilt_y")
_POINTS = "@points"  # cannot occur in quotes of its own inside another text of the file


def experiment_toml(hand: Hand, experiment: Experiment) -> str:
    """Return one run as TOML that needs no other file: the hand's differences stand in it too."""
    import tomli_w

    given = dict(experiment.object.values) if experiment.object else {}
    changes = {**differences(hand), **experiment.values}
    changes = {name: x for name, x in changes.items() if name not in given}
    changes.pop("controller.sampled", None)
    content: dict[str, Any] = {
        "title": experiment.title,
        "hand": "hannes",
        "duration": text(experiment.duration, "s"),
        "sampling": text(experiment.sampling, "Hz"),
        "controller": experiment.controller,
        "effects": effect_names(hand),
        "reference": {
            "kind": "ramp" if experiment.reference.kinked else "file",
            "points": _POINTS,
        },
    }
    if experiment.object is not None:
        content["object"] = _object(hand, experiment.object)
    if experiment.noise or experiment.seed:
        noise = {name: text(spread, NOISE[name]) for name, spread in experiment.noise.items()}
        content["noise"] = {**noise, "seed": experiment.seed}
    if changes:
        content["parameters"] = texts(hand, changes)
    return tomli_w.dumps(content).replace(f'"{_POINTS}"', _points(experiment.reference))


def _points(reference: Reference) -> str:
    """One point a line; tomli_w would spend four on each of perhaps a thousand."""
    rows = [f'    ["{text(t, "s")}", "{text(x, "rad")}"],\n' for t, x in reference.knots.T]
    return f"[\n{''.join(rows)}]"


def _object(hand: Hand, target: Target) -> dict[str, Any]:
    values = target.values
    written: dict[str, Any] = {"shape": target.shape}
    if target.shape == "prism":
        written["size"] = _size(hand, values)
    elif "object.radius" in values:
        written["radius"] = text(values["object.radius"], "m")
    if any(f"object.{axis}" in values for axis in "xyz"):
        written["position"] = [text(_value(hand, values, axis), "m") for axis in "xyz"]
    if any(f"object.{name}" in values for name in TILT):
        written["tilt"] = [text(_value(hand, values, name), "rad") for name in TILT]
    if "object.turn" in values:
        written["turn"] = text(values["object.turn"], "rad")
    material = {key: values[f"object.{key}"] for key in MATERIAL if f"object.{key}" in values}
    if material:
        units = {key: hand.parameters.require(f"object.{key}").unit for key in material}
        written["material"] = {key: text(x, units[key]) for key, x in material.items()}
    return {**written, "sensor": target.sensor}


def _size(hand: Hand, values: Mapping[str, float]) -> dict[str, str]:
    return {
        "width": text(2.0 * _value(hand, values, "half_x"), "m"),
        "height": text(2.0 * _value(hand, values, "half_y"), "m"),
        "rounding": text(_value(hand, values, "radius"), "m"),
    }


def _value(hand: Hand, values: Mapping[str, float], name: str) -> float:
    return values.get(f"object.{name}", hand.parameters[f"object.{name}"])
