"""One number of a hidden effect, as the effect's file declares it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Size:
    """Unit (SI), the value taken unless given, and a physical range.

    `amplitude`: 0, where the effect vanishes exactly, is what is taken; the range then is how
    large the effect may plausibly be, and its sign where both occur. Otherwise it is where or
    how fast the effect acts.
    """

    unit: str
    low: float
    high: float
    default: float = 0.0
    amplitude: bool = True

    @property
    def signs(self) -> dict[str, tuple[float, float, float]]:
        """plus, minus, or both -> sign, and least and largest magnitude that the range has of it.

        A range that holds 0 begins there.
        """
        plus, minus = (1.0, max(self.low, 0.0), self.high), (-1.0, max(-self.high, 0.0), -self.low)
        return {
            name: each for name, each in {"plus": plus, "minus": minus}.items() if each[2] > 0.0
        }
