"""What a campaign does with a hand: conditions, their repeats, and the channels that are logged."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

Points = tuple[tuple[float, float], ...]

PAPER: Points = ((0.0, 0.0), (0.637, 9.84), (1.022, 0.0))  # s, rad at the output shaft
REST = 0.128  # s, logged after a run's last point
DYNAMOMETER: Mapping[str, Any] = {"shape": "cylinder"}  # all else as the hand's `object.*` has it
SOFT_BALL: Mapping[str, Any] = {
    "shape": "sphere",
    "radius": 36e-3,
    "x": 4e-3,
    "y": -47e-3,
    "z": 0.0,
    "stiffness": 800.0,
    "damping": 20.0,
}


@dataclass(frozen=True)
class Condition:
    """One thing done with the hand, and how often; `sensor`: the object measures force.

    also: channels logged beside those of the protocol, with units
    """

    name: str
    points: Points
    repeats: int
    thing: Mapping[str, Any] | None = None
    sensor: bool = False
    also: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """Time logged (s)."""
        return round(self.points[-1][0] + REST, 3)

    @property
    def stem(self) -> str:
        """Name of a file."""
        return self.name.replace(",", "").replace(" ", "-").replace(".", "")


@dataclass(frozen=True)
class Protocol:
    """Conditions in the order of the runs, and the channels logged beside the forces (with units).

    Force and sensor reading are logged where the object has a sensor.
    """

    conditions: tuple[Condition, ...]
    channels: tuple[str, ...]

    @property
    def runs(self) -> list[Condition]:
        """One condition for each run."""
        return [each for each in self.conditions for _ in range(each.repeats)]


def scaled(points: Points, speed: float, amplitude: float = 1.0) -> Points:
    """The same motion at a share of its speed and to a share of its amplitude."""
    stretch = amplitude / speed
    return tuple((round(t * stretch, 6), angle * amplitude) for t, angle in points)


def closures(runs: int) -> Protocol:
    """Free closures against the stops: at full speed, 0.2 s held, 0.2 s at rest after."""
    target, closing, opening = 21.0, 15.4, 25.5  # rad (stops at 19.1), rad/s
    closed = target / closing
    opened = closed + 0.2 + target / opening
    points = ((0.0, 0.0), (closed, target), (closed + 0.2, target), (opened, 0.0))
    return Protocol((Condition("void", points, runs),), RICH)


POOR = ("reference_rad", "position_rad", "current_A")
RICH = (*POOR, "duty_1", "supply_V")

PROTOCOLS = {
    # The paper's two experiments, as its board logs them.
    "poor": Protocol(
        (
            Condition("void", PAPER, 6),
            Condition("dynamometer", PAPER, 6, DYNAMOMETER, sensor=True),
        ),
        POOR,
    ),
    # Sixteen runs that separate what the poor protocol cannot: speeds separate friction laws,
    # amplitude and slowness load-dependent ones, a second stiffness wires from object, duty and
    # supply the electrical part. Three repeats where a condition stands for itself, two where its
    # repeats may be pooled.
    "rich": Protocol(
        (
            Condition("void, full speed", PAPER, 3),
            Condition("void, half speed", scaled(PAPER, 0.5), 2),
            Condition("void, 0.15 speed", scaled(PAPER, 0.15), 2),
            Condition("dynamometer, full speed", PAPER, 3, DYNAMOMETER, sensor=True),
            Condition(
                "dynamometer, 0.85 amplitude",
                scaled(PAPER, 1.0, 0.85),
                2,
                DYNAMOMETER,
                sensor=True,
            ),
            Condition("dynamometer, 0.25 speed", scaled(PAPER, 0.25), 2, DYNAMOMETER, sensor=True),
            Condition("soft ball", PAPER, 2, SOFT_BALL),
        ),
        RICH,
    ),
}
