"""Every tuning constant of the hold-out test, with unit, meaning and how it was chosen."""

from dataclasses import dataclass

from hannes.identification.tuning_table import CONVENTION, COST, NUMERICS, constant


@dataclass(frozen=True)
class HoldoutTuning:
    """When an effect that was fitted on some segments is accepted on others."""

    false_alarms: float = constant(0.01, "1", "accepted for each effect", CONVENTION)
    resamples: int = constant(2000, "1", "of blocks, for the lower limit of a reduction", COST)
    fewest_blocks: int = constant(
        7,
        "1",
        "to judge a reduction by: chance alone favours all of six in 1.6 %, of seven in 0.8 %",
    )
    least_share: float = constant(0.2, "1", "of the reducible chi-squared, to be explained")
    least_reduction: float = constant(0.2, "squared noise floors", "mean over samples, likewise")
    rival_share: float = constant(
        0.8, "1", "of the best reduction: such a rival cannot be separated from it"
    )
    confusable_cosine: float = constant(0.95, "1", "of two signatures", CONVENTION)
    agrees: float = constant(
        1.5, "noise floors", "of the worst channel: what repeats and a nearly right model leave"
    )
    difference_steps: tuple[float, ...] = constant(
        (0.1, 0.01, 0.001), "standard deviations", "of differences, one fit after another", NUMERICS
    )
    scanned_sizes: tuple[float, ...] = constant(
        (-4.0, -1.0, 1.0, 4.0), "twentieths of an effect's range", "from off, where a fit starts"
    )
    silent: float = constant(
        3.0, "noise floors", "of what a channel leaves that answers to no parameter, to count"
    )
    starts_alone: tuple[float, ...] = constant(
        (-1.0, 1.0, -2.0, 2.0, -4.0, 4.0),
        "standard deviations",
        "of each free parameter, where a channel does not answer as given",
    )
    starts_together: int = constant(5, "powers of two", "of points with all moved, likewise", COST)
    starts_looked_at: int = constant(6, "1", "of these, nearest first", COST)
    max_evaluations: int = constant(12, "1", "of each fit", COST)
    moments_per_block: int = constant(4, "1", "of a plant's block, taken as independent")


HOLDOUT = HoldoutTuning()
