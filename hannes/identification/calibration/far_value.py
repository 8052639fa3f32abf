"""Whether a fitted value is farther from the given one than machines differ.

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
    """The parameter that is farthest from its given value.

    name:       "" where nothing is said of given values
    share:      of the given value, by which it is off
    deviations: the same in standard deviations of what machines and the estimate differ by
    p_value:    that chance gives as much to any of the parameters asked for
    """

    name: str = ""
    share: float = 0.0
    deviations: float = 0.0
    p_value: float = 1.0

    @property
    def likely(self) -> bool:
        """Whether the given value is wrong, or the model."""
        return self.p_value < CALIBRATION.far_p_value

    @property
    def sentence(self) -> str:
        """What it means, in words; "" where it means nothing."""
        if not self.likely:
            return ""
        return (
            f"{self.name} ended {100.0 * self.share:+.2g} % from its given value, "
            f"{abs(self.deviations):.1f} times what machines differ by: the given value was wrong, "
            "or the model lacks what this value stands in for; if it was a guess, say how good in "
            "[calibrate.spread]"
        )


def far_value(plan: Plan, answers: Sequence[Answer]) -> FarValue:
    """The value farthest from the given one; answers in the order of the plan."""
    from scipy.stats import norm

    found = [_far(plan, each) for each in answers if plan.usual.get(each.name)]
    farthest = max(found, key=lambda each: abs(each.deviations), default=FarValue())
    chance = min(1.0, 2.0 * float(norm.sf(abs(farthest.deviations))) * max(1, len(found)))
    return FarValue(farthest.name, farthest.share, farthest.deviations, chance)


def _far(plan: Plan, answer: Answer) -> FarValue:
    off = answer.value - answer.nominal
    width = float(np.hypot(plan.usual[answer.name], answer.deviation))
    return FarValue(answer.name, off / (abs(answer.nominal) or 1.0), off / width)


def without_far(answers: Sequence[Answer], far: FarValue) -> list[Answer]:
    """The answers, the far value's no longer identified."""
    reason = "it is farther from its given value than machines differ"
    return [
        replace(each, label=NOT_IDENTIFIED, reason=reason)
        if far.likely and each.name == far.name and each.identified
        else each
        for each in answers
    ]
