"""One sentence on a residual: where it is, what it grows with, alike both ways or not.

Squares of what runs share are products of different runs, so noise adds nothing to them in the
mean. Every figure is computed again with each run left out. A statement is made only where its
whole interval lies beyond what it needs. That is asked first of what runs have in common, at 1 %,
and then of all statements together, at 1 %.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from hannes.campaigns.segments import Segment
from hannes.identification.pattern.blocks import Command, commands
from hannes.identification.pattern.drift import drift
from hannes.identification.pattern.jackknife import Estimate, estimated
from hannes.identification.remainder import Raw
from hannes.plants.protocol import Plant

FEWEST = 3  # runs of a command that say how far runs differ
ALONE, MOST = 0.9, 0.6  # of the squares, for "alone" and for "most of it"
USUAL = 0.75  # of all blocks: what lies in more of them is no place
CLEAR = 0.4  # of a correlation, at least
ANGLES = 12  # at which both ways are compared
ALIKE = 0.05  # of a correlation: of two as clear, the first of these is said
AXES = {"load": "load", "speed": "speed", "angle": "the angle", "time": "the time in the run"}
Statement = dict[str, Any]
Place = Callable[[Command], np.ndarray]  # share of each block inside, shape (blocks,)


def by_stage(
    plant: Plant,
    segments: Sequence[Segment],
    noise_floors: Mapping[str, float],
    stages: Mapping[str, Callable[[], Raw]],
) -> dict[str, Any]:
    """`goes_with` of each stage by its name: what it leaves of every segment."""
    return {n: goes_with(plant, segments, raw(), noise_floors) for n, raw in stages.items()}


def goes_with(
    plant: Plant, segments: Sequence[Segment], raw: Raw, noise_floors: Mapping[str, float]
) -> dict[str, Any]:
    """`sentence`, and its `statements`: each `what`, its figure `value`, `low` the least it is.

    raw: simulated minus recorded of each segment. The sentence is empty where nothing is beyond
    chance; it is not `tested` where no command has repeats enough.
    """
    known, names = commands(plant, segments, raw, noise_floors, FEWEST)
    made: list[Statement | None] = [drift(known)]
    if known and estimated(known, _repeatable, 1).low > 0.0:
        place, phase = _place(known), _phase(known)
        growth = _growth(_inside(_inside(known, place), phase))
        made = [place, phase, _channel(known, names), growth, _both_ways(known), *made]
    found = [each for each in made if each]
    return {
        "sentence": _sentence(found),
        "statements": [{key: each[key] for key in ("what", "value", "low")} for each in found],
        "tested": bool(known),
    }


def _sentence(statements: Sequence[Statement]) -> str:
    text = "; ".join(each["what"] for each in statements)
    return text[:1].upper() + text[1:] + "." if text else ""


def _said(what: str, estimate: Estimate, **more: Any) -> Statement:
    return {"what": what, "value": estimate.value, "low": estimate.low, **more}


def _repeatable(some: Sequence[Command]) -> float:
    """Share of all squares that runs have in common."""
    every = float(sum(np.sum((each.residual / each.spread) ** 2) / each.runs for each in some))
    return _whole(some) / every if every > 0.0 else 0.0


def _whole(some: Sequence[Command]) -> float:
    return float(sum(each.clear.sum() for each in some))


def _share(weights: Sequence[np.ndarray], some: Sequence[Command]) -> float:
    """Of all squares, those with weights of shape (blocks,) or (blocks, channels)."""
    part = 0.0
    for each, weight in zip(some, weights, strict=True):
        part += float(np.sum(each.clear * (weight if weight.ndim == 2 else weight[:, np.newaxis])))
    whole = _whole(some)
    return part / whole if whole > 0.0 else 0.0


def _during(phase: str) -> str:
    return f"while {phase}" if phase.endswith("ing") else f'in the phase "{phase}"'


def _in_mask(name: str) -> Place:
    return lambda each: each.masks.get(name, np.zeros(len(each.square)))


def _in_condition(name: str) -> Place:
    return lambda each: np.full(len(each.square), float(each.condition == name))


def _located(known: Sequence[Command], places: Mapping[str, Place]) -> Statement | None:
    """The narrowest place that has nearly all of the squares, or else the one with most of them."""
    blocks = sum(len(each.square) for each in known)
    found = []
    for words, inside in places.items():
        masses = [inside(each) for each in known]
        covered = float(sum(each.sum() for each in masses)) / blocks
        if not 0.0 < covered < USUAL:
            continue
        share = estimated(known, partial(_share, masses))
        for least, end in ((ALONE, "alone"), (MOST, "most of all")):
            if share.value >= least and share.low > max(0.5, covered):
                found.append((-least, covered, _said(f"{words} {end}", share, inside=inside)))
                break
    return min(found, key=lambda each: each[:2])[2] if found else None


def _place(known: Sequence[Command]) -> Statement | None:
    """By contact, where the plant knows it, else by condition."""
    if touched := _located(known, {"in contact": _in_mask("contact")}):
        return touched
    conditions = dict.fromkeys(each.condition for each in known)
    return _located(known, {f'in "{name}"': _in_condition(name) for name in conditions})


def _phase(known: Sequence[Command]) -> Statement | None:
    names = [n for n in dict.fromkeys(n for c in known for n in c.masks) if n != "contact"]
    return _located(known, {_during(name): _in_mask(name) for name in names})


def _channel(known: Sequence[Command], names: Sequence[str]) -> Statement | None:
    """The channel in which nearly all or most of it is, in noise floors."""
    if len(names) < 2:
        return None
    places = {
        f"in the {name}": [
            np.tile(np.arange(len(names)) == k, (len(each.square), 1)).astype(float)
            for each in known
        ]
        for k, name in enumerate(names)
    }
    shares = {words: estimated(known, partial(_share, w)) for words, w in places.items()}
    words = max(shares, key=lambda each: shares[each].value)
    most = shares[words]
    if most.low <= 0.5:
        return None
    return _said(f"{'nearly all' if most.value >= ALONE else 'most'} of it {words}", most)


def _inside(known: Sequence[Command], place: Statement | None) -> list[Command]:
    """The commands cut to a place; whole where it is none."""
    if place is None:
        return list(known)
    cut = [(each, place["inside"](each) > 0.5) for each in known]
    return [each.only(kept) for each, kept in cut if np.count_nonzero(kept) > 2]


def _growth(known: Sequence[Command]) -> Statement | None:
    """What the size of the residual grows or falls with most clearly."""
    found = []
    for name, words in AXES.items():
        if not known or any(name not in each.quantities for each in known):
            continue
        axes = [each.quantities[name] for each in known]
        ranks = _ranks(np.abs(np.concatenate(axes)) if name != "angle" else np.concatenate(axes))
        if np.ptp(ranks) == 0.0:
            continue
        clear = estimated(known, partial(_correlation, ranks))
        if abs(clear.low) > CLEAR:
            verb = "grows" if clear.value > 0.0 else "falls"
            found.append(_said(f"{verb} with {words}", clear))
    clearest = max((abs(each["value"]) for each in found), default=0.0)
    return next((each for each in found if abs(each["value"]) > clearest - ALIKE), None)


def _ranks(values: np.ndarray) -> np.ndarray:
    from scipy.stats import rankdata

    return np.asarray(rankdata(values), float)


def _correlation(ranks: np.ndarray, some: Sequence[Command]) -> float:
    """Rank correlation of the shared residual's size with a quantity."""
    squares = np.concatenate([each.square.sum(axis=1) for each in some])
    sizes = _ranks(squares)
    if np.ptp(sizes) == 0.0:
        return 0.0
    return float(np.corrcoef(sizes, ranks)[0, 1])


def _both_ways(known: Sequence[Command]) -> Statement | None:
    """Whether forth and back it has one sign at the same angle, or turns with the motion."""
    moving = [each for each in known if {"angle", "speed"} <= set(each.quantities)]
    if not moving:
        return None
    alike = estimated(moving, _alike)
    if abs(alike.low) <= CLEAR:
        return None
    words = "of one sign both ways" if alike.value > 0.0 else "turns its sign with the motion"
    return _said(words, alike)


def _alike(some: Sequence[Command]) -> float:
    """Correlation of the mean residual forth with that back, at the same angles; no centring."""
    products, squares = 0.0, np.zeros(2)
    for each in some:
        angle, speed = each.quantities["angle"], each.quantities["speed"]
        slow = 0.05 * np.abs(speed).max()
        edges = np.linspace(angle.min(), angle.max() + 1e-12, ANGLES + 1)
        bins, mean = np.digitize(angle, edges) - 1, each.residual.mean(axis=0)
        for k in range(ANGLES):
            forth, back = ((bins == k) & (side * speed > slow) for side in (1.0, -1.0))
            if forth.any() and back.any():
                a, b = mean[forth].mean(axis=0), mean[back].mean(axis=0)
                products += float(a @ b)
                squares += float(a @ a), float(b @ b)
    size = float(np.sqrt(squares.prod()))
    return products / size if size > 0.0 else 0.0
