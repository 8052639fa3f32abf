"""From what was found to a verdict: a name, a class, a remainder, or nothing that can be named."""

from dataclasses import dataclass

from hannes.diagnosis.heldout import held_out
from hannes.diagnosis.investigation import CLEAN, LIMIT, SHARE, Found, Trial
from hannes.diagnosis.point import Point
from hannes.diagnosis.remainder import hangs_together

RIVAL = 10.0  # a rival within so much of the best gain is not told from it
CLOSE = 0.04  # of the best gain: so near a rival may come by what no model has right
MOST = 0.8  # of what can be explained, that one effect must, to be named beside a remainder
AGAINST = 4.0  # misfit of recordings held out that a name may add to: two standard deviations of it
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
    if gain < -AGAINST:
        reason = f"{told}, but not that of recordings held out ({gain:.0f})"
        return Choice("unknown", (), reason, found.base)
    told += f", that of recordings held out by {gain:.0f}"
    left = _left(found, trial)
    if not left:
        return _clean(found, trial, told)
    return _unclean(found, trial, f"{told}; {left}")


def _nothing(found: Found, best: Trial | None) -> Choice:
    gain = 0.0 if best is None else best.gain
    least = f"no effect lowers the misfit by the {LIMIT:.0f} that a name needs (best {gain:.0f})"
    if more := _more(found.base, found.bins):
        return Choice("unknown", (), f"refitted, the base leaves {more}, and {least}", found.base)
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


def _left(found: Found, trial: Trial) -> str:
    """What speaks for something more, or an empty string."""
    if more := _more(trial.point, found.bins):
        return f"what is left is {more}"
    rest, needed = found.rest, max(LIMIT, SHARE * trial.gain)
    if rest is not None and rest.gain / found.unit > needed:
        more = rest.effect.replace("_", " ")
        return f"{rest.gain / found.unit:.0f} more would go with {more}, so something else is there"
    return ""


def _clean(found: Found, trial: Trial, told: str) -> Choice:
    if len(trial.effects) > 1:
        return Choice("named", trial.effects, told, trial.point)
    rivals = rivals_of(found, trial)
    if not rivals:
        return Choice("named", trial.effects, told, trial.point)
    names = (*trial.effects, *(each.effects[0] for each in rivals))
    nearest = f"{_names(rivals[0])} comes as near as {rivals[0].gain:.0f}"
    return Choice("one_of", names, f"{told}; {nearest}", trial.point)


def _unclean(found: Found, trial: Trial, told: str) -> Choice:
    explained, first = _explained(found, trial), found.trials[0]
    if len(trial.effects) > 1:
        alone = first.gain / trial.gain
        if alone < MOST:
            return Choice("unknown", (), f"{told}; more than two effects are missing", found.base)
        trial = first
    if explained < MOST or rivals_of(found, first):
        return Choice("unknown", (), told, found.base)
    return Choice("named_with_remainder", trial.effects, told, trial.point)


def _explained(found: Found, trial: Trial) -> float:
    """Share of all that speaks for a missing effect that a trial takes away."""
    gain, slow = trial.gain * found.unit, hangs_together(trial.point)
    beyond = max(found.base.misfit - found.bins, 1.0)
    return min(gain / beyond, gain / (gain + slow.excess) if slow else 1.0)


def rivals_of(found: Found, best: Trial) -> list[Trial]:
    """Effects that these recordings do not tell from the best one."""
    within = max(RIVAL, CLOSE * best.gain)
    return [
        each
        for each in found.trials
        if each.effects != best.effects[:1] and best.gain - each.gain < within
    ]


def _names(trial: Trial) -> str:
    return " with ".join(name.rpartition(":")[2].replace("_", " ") for name in trial.effects)
