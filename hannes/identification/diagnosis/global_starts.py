"""Global (multi-start) initialisation of effects whose signature depends on their size.

An object that stands elsewhere is touched by other fingers first. Its signature at one millimetre
says nothing about the one at four, and no linear guess leads there. The baseline is no start
either: it is biased by the missing effect. So such an effect is started in the nominal machine at
many sizes, and the best of these are refitted. The same is done for effects that the machine's own
parameters nearly absorb, such as wire compliance, and for the likeliest effects where the baseline
leaves far too much: several millimetres of slack are beyond any linear guess. An effect
that promises nothing at any size, all else following, is not started.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hannes.identification.diagnosis.from_onset import looked_at_from_onset
from hannes.identification.diagnosis.gauss_newton import fitted, rounds
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import (
    Fits,
    Progress,
    far_above,
    no_rival,
    started_at,
)
from hannes.identification.diagnosis.score_test import (
    Guess,
    amplitude_names,
    projected,
    secants,
    shapes,
    stepped,
)
from hannes.identification.diagnosis.sizes_looked_at import looked_at_between, looked_at_sizes
from hannes.identification.diagnosis.tuning import FIT, SEARCH
from hannes.plants.part_fault import part_faults


@dataclass(frozen=True)
class Promised:
    """What effects promise in the machine as given.

    others: names that are no faults of like parts;  size_dependent: of these
    of_all: whether all were asked, as they are where the baseline leaves far too much; else those
            that may start globally
    left: name -> chi-squared that would be left at its best size, all else following linearly
    without: the same without any effect
    """

    others: list[str]
    size_dependent: list[str]
    of_all: bool
    left: Mapping[str, float]
    without: float

    def promising(self, name: str) -> bool:
        """Whether an effect promises a share of the most that one does, or none knows.

        Only the shape that an effect has at first was asked.
        """
        left = self.left.get(name, np.inf)
        return left == np.inf or self.without - left >= SEARCH.promising * self.most

    @property
    def most(self) -> float:
        """The largest reduction that one promises."""
        return self.without - min(self.left.values(), default=self.without)


def worth_global_starts(baseline: Linearisation) -> bool:
    """Whether all are started globally: not where that takes much work for little that is left.

    Beside a baseline that leaves little an effect is small, or one that the baseline absorbs, which
    is started so all the same once it is likely.
    """
    return baseline.cheaply_derived or baseline.chi2 > SEARCH.little_left * baseline.residual.size


def promised(nominal: Linearisation, baseline: Linearisation, effects: Sequence[str]) -> Promised:
    """What effects promise, as far as global starts need it."""
    faults = part_faults(nominal.space.effects, effects)
    others = [name for name in effects if name not in faults]
    names, lost = size_dependent(nominal, others), SEARCH.lost_baseline * baseline.residual.size
    of_all = baseline.chi2 > lost
    without = _without(nominal)
    closely = of_all and baseline.cheaply_derived
    asked = [*(others if of_all else names), *faults]
    left = _least(nominal, asked, names, without, closely)
    return Promised(others, names, of_all, left, without)


def global_fits(
    nominal: Linearisation,
    baseline: Linearisation,
    effects: Sequence[str],
    progress: Progress,
    known: Promised | None = None,
) -> Fits:
    """The best fit with each size-dependent or likely effect, of those below the baseline.

    known: what effects promise, where that was asked before
    """
    asked = known or promised(nominal, baseline, effects)
    least, without, names = asked.left, asked.without, [*asked.size_dependent]
    enough = max(baseline.chi2 - SEARCH.name_limit, without - SEARCH.crossed_share * asked.most)
    faults = [name for name in least if name not in asked.others and least[name] < enough]
    names += sorted(faults, key=least.__getitem__)[: SEARCH.likely_faults]
    if asked.of_all:
        likely = sorted(asked.others, key=least.__getitem__)[: SEARCH.likely_effects]
        names += [name for name in likely if name not in names]
    names.sort(key=least.__getitem__)
    names = [name for name in names if least[name] < without - SEARCH.name_limit]
    some = names[: SEARCH.likely_when_lost] if asked.of_all else names
    return _while_near(nominal, baseline, {name: least[name] for name in some}, without, progress)


def faults_from_given(
    nominal: Linearisation, baseline: Linearisation, effects: Sequence[str], progress: Progress
) -> Fits:
    """The same with the likeliest faults of like parts alone, where they promise much.

    Where recordings inform much, what parts are off for themselves takes up most of such a fault: a
    baseline leaves little beside one, and no derivative there leads back.
    """
    faults = part_faults(nominal.space.effects, effects)
    if not faults:
        return {}
    without = _without(nominal)
    least = _least(nominal, faults, [], without)
    most = without - min(least.values(), default=without)
    enough = max(SEARCH.slight, SEARCH.crossed_share * most)
    likely = sorted(least, key=least.__getitem__)[: SEARCH.likely_faults]
    some = {name: least[name] for name in likely if without - least[name] > enough}
    return _while_near(nominal, baseline, some, without, progress)


def _while_near(
    nominal: Linearisation,
    baseline: Linearisation,
    least: Mapping[str, float],
    without: float,
    progress: Progress,
) -> Fits:
    """Fits of the likeliest effects first; later ones that promise far less are passed over.

    least: chi-squared that each would leave, all else following linearly, as without any `without`.
    A fit leaves far less than that, so that one which promises as much as the best is near it, too.
    """
    found: Fits = {}
    far = far_above(baseline, min(least.values(), default=np.inf))
    likeliest = min(least, key=lambda each: least[each], default="")
    for name, left in least.items():
        leader = min(found, key=lambda each: found[each].chi2, default=likeliest)
        best = found[leader].chi2 if found else baseline.chi2
        near = baseline.chi2 - left >= SEARCH.crossed_share * (baseline.chi2 - best)
        near |= without - left >= SEARCH.crossed_share * (without - least[leader])
        if near and left < far:
            found |= fits_from_nominal(nominal, baseline, [name], progress, best)
    return found


def fits_from_nominal(
    nominal: Linearisation,
    baseline: Linearisation,
    effects: Sequence[str],
    progress: Progress,
    below: float = np.inf,
) -> Fits:
    """The best fit with each effect added to the nominal machine, of those below the baseline.

    below: what another effect leaves. One that leaves far more after some steps is not followed.
    """
    found = dict[str, Linearisation]()
    for name in effects:
        progress(f"{name.replace('_', ' ')}, global starts")
        points = sorted(_begun(nominal, name), key=lambda each: each.chi2)[: SEARCH.starts_kept]
        points = [fitted(each, SEARCH.further_steps) for each in points]
        if points:
            best = min(points, key=lambda each: each.chi2)
            far = no_rival(baseline, below)
            found[name] = best if best.chi2 > far else followed(best, min(below, baseline.chi2))
    return {name: point for name, point in found.items() if point.chi2 < baseline.chi2}


def followed(point: Linearisation, below: float) -> Linearisation:
    """The fit after some rounds, until it leaves less than `below`: the best are refined later."""
    made = rounds(point, FIT.settled, below, FIT.settled_above)
    while point.chi2 > below and (further := next(made, None)) is not None:
        point = further
    return point


def absorbed_by_baseline(baseline: Linearisation, guess: Guess) -> bool:
    """Whether the machine's own parameters can do nearly all that a guess does.

    The baseline is then biased by the effect, and far: no derivative there leads back.
    """
    space = baseline.space
    names = amplitude_names(space.effects[guess.effect])
    amplitudes = [guess.places.tolist().index(space.place(name)) for name in names]
    signature = (guess.x[amplitudes] @ guess.signature)[np.newaxis]
    _, beyond = projected(baseline, signature)
    return bool(beyond[0, 0] < SEARCH.own_part * np.sum(signature**2))


def size_dependent(point: Linearisation, effects: Sequence[str]) -> list[str]:
    """The effects whose signature, by any amplitude, is another one where that is large."""
    small = _signatures(point, effects, 1.0)
    sides = [_signatures(point, list(small), side * SEARCH.large_size) for side in (-1.0, 1.0)]
    return [
        name
        for name, rows in small.items()
        if any(_differ(rows, large[name]) for large in sides if name in large)
    ]


def _differ(small: np.ndarray, large: np.ndarray) -> bool:
    """Whether two sets of signatures have a small cosine in any amplitude."""
    return any(
        abs(one @ other) < SEARCH.size_dependent_cosine * np.sqrt((one @ one) * (other @ other))
        for one, other in zip(small, large, strict=True)
    )


def _signatures(point: Linearisation, effects: Sequence[str], size: float) -> dict[str, np.ndarray]:
    """Whitened change by each amplitude at a size, per step, of effects whose range contains it."""
    known = point.space.effects
    trials = [
        (name, shapes(known[name])[0], steps)
        for name in effects
        for steps in stepped(point, name, (1.0, size))[1:]
    ]
    found = secants(point, trials) if trials else []
    return {name: rows for (name, _, _), rows in zip(trials, found, strict=True)}


def _least(
    nominal: Linearisation,
    effects: Sequence[str],
    size_dependent: Sequence[str],
    without: float,
    closely: bool = False,
) -> dict[str, float]:
    """Chi-squared that each effect would leave at its best size, all else following.

    The right size of a size-dependent one may lie in a valley narrower than a few sizes show. So
    may that of a fault, which is looked at more closely where it promises enough.
    closely: at every size of a fault that acts from some size on, too
    """
    faults = part_faults(nominal.space.effects, effects)
    few = dict.fromkeys(effects, SEARCH.few_sizes)
    few |= {name: SEARCH.few_sizes + SEARCH.far_sizes for name in faults}
    sizes = few | dict.fromkeys(size_dependent, SEARCH.every_size)
    found = {name: looked_at_sizes(nominal, name, each) for name, each in sizes.items()}
    for name in faults if closely else ():
        found[name] = looked_at_from_onset(nominal, name, found[name])
    least = {name: float(left.min(initial=np.inf)) for name, (_, left) in found.items()}
    enough = SEARCH.promising * (without - min(least.values(), default=without))
    for name in faults:
        if without - least[name] >= enough:
            least[name] = float(looked_at_between(nominal, name, found[name])[1].min())
    return least


def _without(nominal: Linearisation) -> float:
    """Chi-squared that would be left without any effect, all else following linearly."""
    return float(nominal.chi2_at(nominal.x[np.newaxis], following=True)[0])


def _begun(nominal: Linearisation, name: str) -> list[Linearisation]:
    """A few steps from the best of all sizes that are no neighbours."""
    own = nominal.space.of(name)
    fault = bool(part_faults(nominal.space.effects, [name]))
    sizes = SEARCH.global_sizes + SEARCH.far_sizes * fault
    if not fault and size_dependent(nominal, [name]):
        sizes = SEARCH.every_size
    looked = looked_at_sizes(nominal, name, sizes)
    looked = looked_at_between(nominal, name, looked) if fault else looked
    if fault and nominal.cheaply_derived:
        looked = looked_at_from_onset(nominal, name, looked)
    rows, left = looked
    best = _apart(rows[np.argsort(left)], nominal.x)
    points = [started_at(nominal, own, row[own]) for row in best]
    return [fitted(each, SEARCH.start_steps) for each in points if each is not None]


def _apart(rows: np.ndarray, x: np.ndarray) -> list[np.ndarray]:
    """The first rows that are some steps apart, as few as are tried; of neighbours the first."""
    found: list[np.ndarray] = []
    steps, share = SEARCH.apart
    for row in rows:
        least = max(steps, share * float(np.linalg.norm(row - x)))
        if len(found) < SEARCH.starts_tried and all(
            np.linalg.norm(row - each) >= least for each in found
        ):
            found.append(row)
    return found
