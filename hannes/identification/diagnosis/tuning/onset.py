"""Constants of faults that begin to act from some size on."""

from dataclasses import dataclass

from hannes.identification.tuning_table import COST, constant


@dataclass(frozen=True)
class OnsetTuning:
    """At which sizes such a fault is looked at."""

    acts: float = constant(1.0, "chi2", "that a fault changes where it acts")
    later: float = constant(
        6.0, "steps", "at which one that begins to act from some size on does not act"
    )
    farthest: float = constant(60.0, "steps", "that one is looked at, at most", COST)


ONSET = OnsetTuning()
