"""How certain a figure is that several commands' runs give: each run is left out in turn."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hannes.identification.pattern.blocks import Command

LEVEL = 0.01  # two-sided, over all statements together
STATEMENTS = 12  # that may be made at most


@dataclass(frozen=True)
class Estimate:
    """A figure, and how far it may be off by chance at the level."""

    value: float
    reach: float

    @property
    def low(self) -> float:
        """The end of its interval that is nearer to zero and beyond, 0 where it contains zero."""
        return float(np.sign(self.value) * max(0.0, abs(self.value) - self.reach))


def estimated(
    commands: Sequence[Command],
    figure: Callable[[Sequence[Command]], float],
    statements: int = STATEMENTS,
) -> Estimate:
    """A figure of commands with its interval (Tukey 1958), by Student's t.

    statements: that share the level. Every command has at least three runs.
    """
    from scipy.stats import t

    variance = 0.0
    for k, each in enumerate(commands):
        left = np.array(
            [
                figure([*commands[:k], each.without(run), *commands[k + 1 :]])
                for run in range(each.runs)
            ]
        )
        variance += (each.runs - 1) / each.runs * float(np.sum((left - left.mean()) ** 2))
    freedom = sum(each.runs - 1 for each in commands)
    quantile = float(t.ppf(1.0 - 0.5 * LEVEL / statements, freedom))
    return Estimate(figure(commands), quantile * float(np.sqrt(variance)))
