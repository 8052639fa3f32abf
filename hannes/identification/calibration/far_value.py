"""Fitted values that are farther from the given ones than machines differ.

What a model lacks may look like another value of a parameter: a hot winding like a larger
resistance. Nothing is left then for a test of what remains. But the value is far from the given
one, by what the campaign says of given values (`spread`, else `doubt`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.identification.calibration.identifiability import NOT_IDENTIFIED, Answer
from hannes.identification.calibration.settings import Plan
from hannes.identification.calibration.tuning import CALIBRATION


@dataclass(frozen=True)
class FarValue:
    """A parameter that is farther from its given value than chance takes any asked for.

    off:        how far, as a reader is given it
    deviations: the same in standard deviations of what machines and the estimate differ by
    p_value:    that chance gives as much to any of the parameters asked for
    """

    name: str
    off: str
    deviations: float
    p_value: float

    @property
    def sentence(self) -> str:
        """What it means, in words."""
        return (
            f"{self.name} ended {self.off} from its given value, {abs(self.deviations):.1f} times "
            "what machines differ by: the given value was wrong, or the model lacks what this "
            "value stands in for; if it was a guess, say how good in [calibrate.spread]"
        )


def far_values(plan: Plan, answers: Sequence[Answer]) -> tuple[FarValue, ...]:
    """Those of the answers that are far, the least probable first; answers as in the plan."""
    known = [each for each in answers if plan.usual.get(each.name)]
    found = [_far(plan.usual[each.name], each, len(known)) for each in known]
    likely = [each for each in found if each.p_value < CALIBRATION.far_p_value]
    return tuple(sorted(likely, key=lambda each: each.p_value))


def _far(usual: float, answer: Answer, count: int) -> FarValue:
    """Of one of `count` answers; given values are off by `usual` (one standard deviation, SI)."""
    from scipy.stats import t as student

    own = answer.deviation if np.isfinite(answer.deviation) else np.inf
    variance = usual**2 + own**2
    # Welch and Satterthwaite: what machines differ by is stated, the rest is from few runs.
    freedom = answer.freedom * (variance / own**2) ** 2 if 0.0 < own < np.inf else np.inf
    deviations = (answer.value - answer.nominal) / np.sqrt(variance)
    chance = 2.0 * float(student.sf(abs(deviations), freedom))
    return FarValue(answer.name, _off(answer), float(deviations), min(1.0, count * chance))


def _off(answer: Answer) -> str:
    """`+21 %`, or a difference with its unit where nothing was given."""
    difference = answer.value - answer.nominal
    if answer.nominal == 0.0:
        return f"{difference:+.3g} {answer.unit}"
    percent = 100.0 * difference / abs(answer.nominal)
    return f"{percent:+.0f} %" if abs(percent) >= 10.0 else f"{percent:+.2g} %"


def without_far(answers: Sequence[Answer], far: Sequence[FarValue]) -> list[Answer]:
    """The answers, those that are far no longer identified."""
    names = {each.name for each in far}
    reason = "it is farther from its given value than machines differ"
    return [
        replace(each, label=NOT_IDENTIFIED, reason=reason)
        if each.name in names and each.identified
        else each
        for each in answers
    ]
