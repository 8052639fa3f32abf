"""What an honest recording of a channel looks like, as far as a plant can say."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Expected:
    """What a plant knows of one channel before anything is fitted; all of it may be left out.

    follows:  the commanded channel that it tracks with a gain of one
    drives:   the channel that a positive value of this one sets moving in + direction
    peak:     smallest and largest plausible peak magnitude [unit of the channel]
    limit:    magnitude [unit] at which the machine itself saturates, 0 for none
    rate:     fastest plausible change [unit/s], 0 where it is unknown
    lag:      longest time [s] that it takes behind what it follows, 0 where it is unknown
    forward:  whether it is positive nearly always
    mistakes: what was mistaken -> the factor by which the values are then too large
    """

    follows: str = ""
    drives: str = ""
    peak: tuple[float, float] = (0.0, float("inf"))
    limit: float = 0.0
    rate: float = 0.0
    lag: float = 0.0
    forward: bool = False
    mistakes: Mapping[str, float] = field(default_factory=dict)
