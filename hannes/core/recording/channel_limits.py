"""Plausible limits of a recorded channel, as a plant declares them."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Expected:
    """Plausible limits of one channel, known before anything is fitted; all may be left out.

    follows:  the commanded channel that it tracks with a gain of one
    drives:   the channel that a positive value of this one moves in + direction
    peak:     smallest and largest plausible peak magnitude [unit of the channel]
    limit:    magnitude [unit] at which the machine saturates, 0 for none
    rate:     fastest plausible change [unit/s], 0 where it is unknown
    lag:      longest plausible lag [s] behind the channel it follows, 0 where it is unknown
    forward:  whether it is positive nearly always
    mistakes: a mistake, in words -> the factor by which the values are then too large
    """

    follows: str = ""
    drives: str = ""
    peak: tuple[float, float] = (0.0, float("inf"))
    limit: float = 0.0
    rate: float = 0.0
    lag: float = 0.0
    forward: bool = False
    mistakes: Mapping[str, float] = field(default_factory=dict)
