"""The residual of a fit: is it the same in every run?"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hannes.identification.binned_run import View
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.tuning import CALIBRATION


@dataclass(frozen=True)
class RepeatableResidual:
    """Whether the residual is the same in every run of a condition.

    repeats:  True, False, or None where that is unknown: no repeats, or too few
    chance:   probability of as much agreement if runs differed at random (signs flipped)
    smallest: the least that `chance` can be with so many runs
    share:    of the squared whitened residual, the part that repeats, 0 to 1
    common:   channel -> RMS of the part that repeats [its unit]
    ratio:    RMS of the mean residual over what the spread of repeats leaves in a mean, 1 by chance
    hidden:   the most of that ratio which a residual that repeats may have and not show (95 %)
    """

    repeats: bool | None
    chance: float
    share: float
    common: dict[str, float]
    smallest: float = 1.0
    ratio: float = 0.0
    hidden: float = float("inf")

    @property
    def misleads(self) -> bool:
        """Whether the residual is too large beside the spread of repeats to trust any interval."""
        return bool(self.repeats) or self.ratio > CALIBRATION.misleading_ratio

    @property
    def sentence(self) -> str:
        """The result in words."""
        if self.repeats is None and self.smallest == 1.0:
            return "No condition was recorded twice, so it is unknown whether the residual repeats"
        share = f"{100 * self.share:.0f} % of the residual is the same in every run"
        if self.repeats is None:
            text = (
                f"Too few runs to decide whether the residual repeats ({share}; so few runs agree "
                f"by chance with a probability of {self.smallest:.2g} at best, and one of "
                f"{self.hidden:.2g} times what repeats leave may not show)"
            )
            if self.misleads:
                text += f", but it is {self.ratio:.2g} times what repeats leave: record more runs"
            return text
        if not self.repeats:
            return (
                f"The residual does not repeat from run to run beyond chance ({share}); one of "
                f"{self.hidden:.2g} times what repeats leave would show"
            )
        return (
            f"The residual repeats from run to run ({share}): the model lacks something, "
            "and no interval here allows for that; see `hannes diagnose`"
        )


def repeatable_residual(found: State) -> RepeatableResidual:
    """Compare the residuals in the runs of each condition: by their signs, and by their spread.

    Random signs say how often chance agrees as well; n runs of one condition cannot give less than
    2^(1 - n). The second witness is the spread of repeats: the mean residual beside what that
    spread leaves in a mean, by the F distribution for runs that differ in one way alone, the widest
    that there is. Absence is stated only where both could have seen a residual of
    `absent_ratio` times what repeats leave.
    """
    groups = _groups(found)
    if not groups:
        return RepeatableResidual(None, 1.0, 0.0, {})
    common = sum(_shared(rows) for rows in groups)
    whole = sum(float(np.sum(rows**2)) / len(rows) for rows in groups)
    share = float(np.clip(common / max(whole, 1e-300), 0.0, 1.0))
    chance, smallest = _chance(groups, found.plan.seed), _smallest(groups)
    ratio, beyond, hidden = _beside_spread(groups)
    signs = chance <= CALIBRATION.repeat_p_value
    repeats = (signs or beyond) and share >= CALIBRATION.repeat_share
    seen = smallest <= CALIBRATION.repeat_p_value and hidden <= CALIBRATION.absent_ratio
    return RepeatableResidual(
        repeats if repeats or seen else None,
        chance, share, _by_channel(found), smallest, ratio, hidden,
    )  # fmt: skip


def _smallest(groups: Sequence[np.ndarray]) -> float:
    """Least probability that the test of signs can reach."""
    return float(np.prod([2.0 ** (1 - len(rows)) for rows in groups]))


def _beside_spread(groups: Sequence[np.ndarray]) -> tuple[float, bool, float]:
    """Mean residual over what the spread of repeats leaves in it, and whether that is no chance.

    The third is the upper end (95 %) of that ratio without chance; a ratio that is by chance
    below one makes it no smaller.
    """
    from scipy.stats import f

    means = sum(len(rows) * float(np.sum(rows.mean(axis=0) ** 2)) for rows in groups)
    apart = sum(float(np.sum((rows - rows.mean(axis=0)) ** 2)) for rows in groups)
    free = sum(len(rows) - 1 for rows in groups)
    square = (means / len(groups)) / max(apart / free, 1e-300)
    limit = f.ppf(1.0 - CALIBRATION.spread_p_value, len(groups), free)
    most = _largest_hidden(max(square, 1.0), len(groups), free)
    return float(np.sqrt(square)), bool(square > limit), most


def _largest_hidden(square: float, groups: int, free: int) -> float:
    """The ratio of a residual that repeats which gives so little in one of 20 campaigns."""
    from scipy.optimize import brentq
    from scipy.stats import ncf

    def chance(noncentrality: float) -> float:
        return float(ncf.cdf(square, groups, free, noncentrality)) - 0.05

    if chance(1e-9) <= 0.0:
        return 0.0
    top = float(groups)
    while (above := chance(top)) > 0.0:
        top *= 2.0
    return (
        float(np.sqrt(brentq(chance, 1e-9, top) / groups)) if np.isfinite(above) else float("inf")
    )


def _groups(found: State) -> list[np.ndarray]:
    """Whitened residual of the runs of each repeated condition, shape (runs, n) each."""
    return _by_condition(found.model.views, found.whitened_residuals())


def _by_condition(views: Sequence[View], rows: Sequence[np.ndarray]) -> list[np.ndarray]:
    groups: dict[tuple[str, int], list[np.ndarray]] = {}
    for view, row in zip(views, rows, strict=True):
        groups.setdefault((view.entry.condition, row.size), []).append(row)
    return [np.array(each) for each in groups.values() if len(each) > 1]


def _shared(rows: np.ndarray) -> float:
    """Unbiased square of what all rows share: mean product of different rows."""
    count = len(rows)
    return float((np.sum(rows.sum(axis=0) ** 2) - np.sum(rows**2)) / (count * (count - 1)))


def _chance(groups: Sequence[np.ndarray], seed: int) -> float:
    """How often runs with random signs agree as well as they do."""
    rng = np.random.default_rng(seed)
    products = [rows @ rows.T for rows in groups]

    def agreement(signs: Sequence[np.ndarray]) -> float:
        return sum(float(s @ each @ s) for s, each in zip(signs, products, strict=True))

    vectors = agreement([np.ones(len(each)) for each in groups])
    drawn = [
        agreement([rng.choice((-1.0, 1.0), len(each)) for each in groups])
        for _ in range(CALIBRATION.permutations)
    ]
    return (1 + int(np.sum(np.array(drawn) >= vectors * (1.0 - 1e-12)))) / (
        1 + CALIBRATION.permutations
    )


def _by_channel(found: State) -> dict[str, float]:
    """RMS of what repeats in each channel [its unit]."""
    common = {}
    for number, name in enumerate(found.model.views[0].names):
        parts = [
            residual[view.part == number]
            for residual, view in zip(found.residuals, found.model.views, strict=True)
        ]
        groups = [each for each in _by_condition(found.model.views, parts) if each.size]
        if groups:
            count = sum(each.shape[1] for each in groups)
            square = sum(_shared(each) for each in groups) / count
            common[name] = float(np.sqrt(max(square, 0.0)))
    return common
