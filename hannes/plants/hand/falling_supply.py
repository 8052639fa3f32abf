"""A supply that falls from run to run: each run of a campaign starts with less than the last."""

from hannes.core.effect import Effect
from hannes.core.parameter import Parameter
from hannes.plants.part_fault import PartFault

# Twice what a pack of 8 Wh loses from full to empty (3.6 V) in a campaign of some thirty runs.
MOST = 0.25  # V


def falling_supply() -> dict[str, Effect]:
    """By name: the supply of the k-th run is lower by k times its size, counted from 0."""
    fall = Parameter(
        "fall", 0.0, "V", (0.0, MOST), "of the supply, from each run to the next", off=0
    )
    found = PartFault(
        "falling_supply",
        "The supply falls from each run of a campaign to the next, as a battery's does.",
        "V_0 of run k = V_0 - k fall, k = 0, 1, 2 ...; hand.toml has run 0",
        "Tremblay & Dessaint (2009), a battery's voltage over its charge",
        (fall,),
        (),
        moves={"fall": {"supply.voltage": -1.0}},
        by_run=True,
    )
    return {found.name: found}
