"""From what was found to a verdict: a name, a class, a remainder, or nothing that can be named."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.core.parameter import Parameter
from hannes.identification.diagnosis.drift import Drift, drifts
from hannes.identification.diagnosis.effect_search import (
    CLEAN,
    FAINT,
    LIMIT,
    SHARE,
    Found,
    Trial,
    near,
)
from hannes.identification.diagnosis.gauss_newton import LIGHT
from hannes.identification.diagnosis.generic_disturbances import SPOKEN
from hannes.identification.diagnosis.heldout import held_out
from hannes.identification.diagnosis.linearisation import Point
from hannes.identification.diagnosis.prior_distance import Strain, strain
from hannes.identification.diagnosis.residual_tests import Slow, hangs_together, stands_out

MOST = 0.8  # of what can be explained, that one effect must, to be named beside a remainder
HALF = 0.5  # of a pair's gain, that the one must which all near pairs have in common
AGAINST = 4.0  # misfit of recordings held out that a name may add to,
ALLOWED = 0.05  # or so much of its gain, if that is more and no more than a name needs
DOUBT = 10.5  # gain of an effect too little to name it, but more than chance leaves
OUTSIDE = 11.0  # the same of what has no name, at its own price of chance
FURTHER = 8.0  # gain of an effect that is not named beside a first, but tells a remainder
GROWN = 36.0  # gain of what grows from run to run, that is told
GROWN_BESIDE = 12.0  # the same beside a name, which is no clean one then
BEYOND = 4.0  # of the misfit: what an effect would gain beyond the end of a range, to be doubted
STRAINED = 0.005  # chance of a machine so far from its given values, that doubts a clean name
FIT = 1.15  # times the bins: a base as given that leaves no more agrees


@dataclass(frozen=True)
class Choice:
    """The verdict's kind, the effects named, why, and the point that the result stands for."""

    kind: str
    effects: tuple[str, ...]
    reason: str
    point: Point


def chosen(found: Found, seen: list[int], unseen: list[int]) -> Choice:
    """The verdict. `seen`, `unseen`: bit masks of each group's runs to fit and to choose by."""
    best = found.trials[0] if found.trials else None
    if best is None or best.gain < LIMIT:
        return _nothing(found, best)
    trial = found.pair or best
    gain = held_out(found.base, trial.point, seen, unseen) / found.unit
    told = f"{_names(trial)} lowers the misfit by {trial.gain:.0f} (limit {LIMIT:.0f})"
    if not gain >= -allowed(trial.gain):  # nor where it cannot be told
        reason = f"{told}, but not that of recordings held out ({gain:.0f})"
        return Choice("unknown", (), reason, found.base)
    if any(seen) and any(unseen):
        told += f", that of recordings held out by {gain:.0f}"
    if doubt := _doubted(found, trial):
        return Choice("unknown", (), f"{told}, but {doubt}", found.base)
    if left := _left(found, trial):
        return _unclean(found, trial, f"{told}; {left}")
    return _beside(found, trial, _clean(found, trial, told))


def allowed(gain: float) -> float:
    """What a name of this gain may add to the misfit of recordings held out: refits differ."""
    return min(max(AGAINST, ALLOWED * gain), LIMIT)


def _nothing(found: Found, best: Trial | None) -> Choice:
    gain = 0.0 if best is None else best.gain
    least = f"no effect lowers the misfit by the {LIMIT:.0f} that a name needs (best {gain:.0f})"
    if drift := _growing(found, found.base):
        return Choice("unknown", (), f"{_told(found, drift)}, and {least}", found.base)
    if more := _more(found.base, found.bins):
        return Choice("unknown", (), f"refitted, the base leaves {more}, and {least}", found.base)
    if slow := stands_out(found.base):
        more = f"more in {slow.where} than the machine's own values can (p = {slow.chance:.1g})"
        return Choice("unknown", (), f"refitted, the base leaves {more}, and {least}", found.base)
    if found.anything and found.anything.gain >= OUTSIDE:
        spoken = SPOKEN[found.anything.effects[0]]
        reason = f"{spoken} would lower the misfit by {found.anything.gain:.0f}, and {least}"
        return Choice("unknown", (), reason, found.base)
    if gain >= DOUBT:
        name = _names(found.trials[0])
        reason = f"{name} lowers the misfit by {gain:.0f}, where a name needs {LIMIT:.0f}"
        return Choice("unknown", (), reason, found.base)
    if found.given.misfit <= FIT * found.bins:
        return Choice("no_gap", (), f"as given it leaves what is expected, and {least}", found.base)
    per_bin = found.base.misfit / found.bins
    reason = f"refitted, the base leaves {per_bin:.2f} per bin (1 expected), and {least}"
    return Choice("recalibrated", (), reason, found.base)


def _more(point: Point, bins: int) -> str:
    """What a point leaves that noise does not, in words; an empty string where there is none."""
    if point.misfit > CLEAN * bins:
        return f"{point.misfit / bins:.2f} per bin (1 expected)"
    if slow := hangs_together(point):
        return f"more in {slow.where} than chance (p = {slow.chance:.1g})"
    return ""


def _doubted(found: Found, trial: Trial) -> str:
    """Why effects that explain much are not what is there, or an empty string."""
    if name := _stretched(found, trial):
        return f"only with {name} at an end of its range and beyond: something like it is there"
    if found.anything and found.anything.gain > FAINT and near(trial, [found.anything]):
        spoken = SPOKEN[found.anything.effects[0]]
        return f"{spoken} does by {found.anything.gain:.0f}: something else may be there"
    return ""


def _stretched(found: Found, trial: Trial) -> str:
    """A parameter that would go beyond its physical range, in words, or an empty string."""
    space = trial.point.ground.model.space
    for effect in (space.effects[name] for name in trial.effects):
        for each in effect.parameters:
            place = space.place(effect.full_name(each.name))
            value = float(space.directions[place].value(trial.point.x[place]))
            if _at_end(each, value) and _beyond(trial.point, place) > BEYOND * found.unit:
                return f"{effect.name}'s {each.name}".replace("_", " ")
    return ""


def _at_end(parameter: Parameter, value: float) -> bool:
    """Tell whether a range ends there: `off` is no end, and what counts or turns has none."""
    low, high = parameter.bounds
    ends = [end for end in (low, high) if end != parameter.off]
    endless = parameter.turns is not None or parameter.tried
    return not endless and min(abs(value - end) for end in ends) <= 1e-9 * (high - low)


def _beyond(point: Point, place: int) -> float:
    """What a step along one direction would lower the misfit by, all else following.

    At an end of a range that is a step out of it: a fit that could go inward has gone.
    """
    number = int(np.searchsorted(point.active, place))
    inverse = np.linalg.inv(point.curvature + LIGHT * np.eye(point.active.size))
    return float(point.pull[number] ** 2 * inverse[number, number])


def _left(found: Found, trial: Trial) -> str:
    """What speaks for something more, or an empty string."""
    if drift := _growing(found, trial.point):
        return _told(found, drift)
    if more := _more(trial.point, found.bins):
        return f"what is left is {more}"
    if slow := _outdone(found, trial):
        more = f"{slow.excess / found.unit:.0f} stand out in {slow.where} alone"
        return f"{more}, so something else is there"
    rest, needed = found.rest, max(LIMIT, SHARE * trial.gain)
    if rest is not None and rest.gain / found.unit > needed:
        more = rest.effect.replace("_", " ")
        return f"{rest.gain / found.unit:.0f} more would go with {more}, so something else is there"
    if strained := _strained(trial):
        times = f"{strained.times:.1f} times as far as scatter tells"
        return f"it takes a machine whose values are off {times}: so they are, or hide something"
    return ""


def _strained(trial: Trial) -> Strain | None:
    """How far the machine that goes with these effects is off, where that is no chance."""
    found = strain(trial.point)
    return found if found.chance < STRAINED else None


def _outdone(found: Found, trial: Trial) -> Slow | None:
    """What stands out of the base in one channel, where far less than that is explained in all.

    What shows in one channel alone is about as much by both, and which is more is chance.
    """
    slow = stands_out(found.base)
    return slow if slow is not None and MOST * slow.excess > _lowered(found, trial) else None


def _lowered(found: Found, trial: Trial) -> float:
    return found.base.misfit - trial.point.misfit


def _growing(found: Found, point: Point, least: float = GROWN) -> Drift | None:
    """What grows from run to run, where that lowers the misfit by enough to tell it."""
    drift = drifts(point, found.guesses)
    return drift if drift is not None and drift.gain > least * found.unit else None


def _told(found: Found, drift: Drift) -> str:
    name = drift.effect.replace("_", " ")
    return f"{drift.gain / found.unit:.0f} would go with {name} that grows from run to run"


def _clean(found: Found, trial: Trial, told: str) -> Choice:
    if len(trial.effects) > 1:
        return _pair(found, trial, told)
    rivals = near(trial, found.trials)
    if not rivals:
        more = _faintly(found, trial)
        kind = "named_with_remainder" if more else "named"
        return Choice(kind, trial.effects, told + more, trial.point)
    names = (*trial.effects, *(each.effects[0] for each in rivals))
    return Choice("one_of", names, f"{told}; {_nearest(rivals)}", trial.point)


def _beside(found: Found, trial: Trial, choice: Choice) -> Choice:
    """The choice with a remainder where a little grows beside it, unless that explains more."""
    drift = _growing(found, trial.point, GROWN_BESIDE)
    if drift is None or choice.kind != "named":
        return choice
    instead = _growing(found, found.base, GROWN_BESIDE)
    reason = f"{choice.reason}; {_told(found, drift)}"
    if instead and instead.gain > trial.gain * found.unit:
        return Choice("unknown", (), reason, found.base)
    return replace(choice, kind="named_with_remainder", reason=reason)


def _faintly(found: Found, trial: Trial) -> str:
    """What is left after a single effect, too little to be named, or an empty string."""
    rest = found.rest
    if rest is None or rest.gain / found.unit < max(FURTHER, 0.5 * SHARE * trial.gain):
        return ""
    name = rest.effect.replace("_", " ")
    return f"; {rest.gain / found.unit:.0f} more would go with {name}, too little to name it"


def _pair(found: Found, trial: Trial, told: str) -> Choice:
    """Two effects; where others would do as well, what is common to all pairs."""
    rivals = near(trial, found.other_pairs)
    if not rivals:
        return Choice("named", trial.effects, told, trial.point)
    told = f"{told}; {_nearest(rivals)}"
    common = set(trial.effects).intersection(*(each.effects for each in rivals))
    alone = [each for each in found.trials if set(each.effects) <= common]
    if not alone or alone[0].gain < max(LIMIT, HALF * trial.gain):
        return Choice("unknown", (), told, found.base)
    return Choice("named_with_remainder", alone[0].effects, told, alone[0].point)


def _nearest(rivals: Sequence[Trial]) -> str:
    return f"{_names(rivals[0])} comes as near as {rivals[0].gain:.0f}"


def _unclean(found: Found, trial: Trial, told: str) -> Choice:
    explained, first = _explained(found, trial), found.trials[0]
    if len(trial.effects) > 1:
        explained *= first.gain / trial.gain
    if explained < MOST or near(first, found.trials):
        return Choice("unknown", (), told, found.base)
    return Choice("named_with_remainder", first.effects, told, first.point)


def _explained(found: Found, trial: Trial) -> float:
    """Share of all that speaks for a missing effect that a trial takes away.

    Nothing where something that grows from run to run would take away more.
    """
    gain, slow = trial.gain * found.unit, hangs_together(trial.point)
    drift, instead = (_growing(found, p) for p in (trial.point, found.base))
    if drift and instead and instead.gain > gain:
        return 0.0
    beyond = max(found.base.misfit - min(1.0, found.unit) * found.bins, 1.0)
    strained = _strained(trial)
    rests = (
        slow.excess if slow else 0.0,
        drift.gain if drift else 0.0,
        strained.excess if strained else 0.0,
    )
    shares = [gain / beyond, *(gain / (gain + rest) for rest in rests)]
    if out := _outdone(found, trial):
        shares.append(_lowered(found, trial) / out.excess)
    return min(shares)


def _names(trial: Trial) -> str:
    return " with ".join(name.rpartition(":")[2].replace("_", " ") for name in trial.effects)
