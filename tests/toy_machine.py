"""A machine that needs no model: its shaft follows the reference with a lag."""

from hannes.bench.messages import Channel

CHANNELS = (
    Channel(0, "reference", "rad", "i", 1e-6),
    Channel(1, "position", "rad", "i", 1e-6),
    Channel(2, "current", "A", "h", 1e-3),
)


class Lag:
    """Position approaches the reference by a twentieth a tick; current is their difference."""

    channels = CHANNELS

    def __init__(self) -> None:
        self.position = 0.0
        self.ticks = 0

    def step(self, reference: float | None) -> dict[str, float]:
        self.ticks += 1
        wanted = self.position if reference is None else reference
        current = wanted - self.position
        self.position += 0.05 * current
        return {"reference": wanted, "position": self.position, "current": current}
