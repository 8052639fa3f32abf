"""Constants of the fits: differences, Gauss-Newton steps, profiles, and bins."""

from dataclasses import dataclass

from hannes.identification.tuning_table import COST, DEVELOPMENT, NUMERICS, constant


@dataclass(frozen=True)
class FitTuning:
    """How chi-squared is differenced and minimised."""

    bins: int = constant(115, "1", "of each channel, at most: longer runs have wider bins", COST)
    machine_step: float = constant(
        0.5, "standard deviations", "by which the machine's values are differenced", NUMERICS
    )
    effect_step: float = constant(
        0.3, "steps", "by which an effect's parameter is differenced", NUMERICS
    )
    other_steps: tuple[float, ...] = constant(
        (1.0, 0.3, -0.3, 0.1), "1", "of a step whose run fails, tried in turn", NUMERICS
    )
    steps_per_range: float = constant(60.0, "1", "in the range of an effect's parameter", NUMERICS)
    effect_prior_weight: float = constant(
        1e-3, "1/steps^2", "of an effect's size: it regularises and hardly pulls", NUMERICS
    )
    points_as_changes: int = constant(
        4, "1", "points from which on they are simulated as changes, at a wider tolerance", COST
    )
    kept_reduction: float = constant(
        0.3, "1", "of the predicted reduction, which a whole step must reach", NUMERICS
    )
    shorter_steps: tuple[tuple[float, float], ...] = constant(
        ((0.0, 0.35), (0.3, 1.0), (3.0, 1.0), (30.0, 1.0), (300.0, 1.0)),
        "1",
        "Levenberg's damping of a step and a share of it, tried together where it does not",
        NUMERICS,
    )
    rounds: int = constant(5, "1", "of new derivatives, at most, until a fit has converged", COST)
    steps_per_round: int = constant(5, "1", "with derivatives updated by Broyden's rule", COST)
    converged: float = constant(0.3, "chi2", "reduction of the last step", DEVELOPMENT)
    near_parts: float = constant(
        1.1, "1", "per bin, of a baseline about which parts are put where it has them", DEVELOPMENT
    )
    little_neglected: float = constant(
        8.0,
        "chi2",
        "of what is not linear in parts, below which none is moved: half of what a name needs",
        DEVELOPMENT,
    )
    farthest_part: float = constant(
        4.0, "standard deviations", "to which a part is put at most", DEVELOPMENT
    )
    part_rounds: int = constant(
        6, "1", "of fits, at most, about parts as the fit before has them", COST
    )
    parts_stay: float = constant(
        0.1, "standard deviations", "by which parts move less once they are as a fit has them", COST
    )
    same_parts: float = constant(
        3.0, "chi2", "by which such a fit differs from the one before, once parts stay", DEVELOPMENT
    )
    farthest: float = constant(
        10_000.0,
        "chi2",
        "of a machine's distance from its prior: one beyond may take minutes, and is not there",
        COST,
    )
    settled: float = constant(
        1.0, "chi2", "likewise, of a round with new derivatives in the search", COST
    )
    settled_per_bin: float = constant(5e-4, "chi2 per bin", "likewise, where that is more", COST)
    settled_share: float = constant(
        0.05,
        "1",
        "likewise, of what is left beyond `settled_above`: no law that is missing is fitted so",
        COST,
    )
    settled_above: float = constant(1.3, "chi2 per bin", "that a fit near to noise leaves")
    settled_finally: float = constant(
        3.0, "chi2 per bin", "likewise, of a fit whose parameters are reported"
    )
    least_information: float = constant(
        0.4, "1", "of the prior's: a parameter with less in the data keeps its derivatives", COST
    )
    jitter: float = constant(1e-6, "1", "added to the Hessian's diagonal, to invert it", NUMERICS)
    finer_bins: int = constant(2, "1", "times as many bins in the final fit", COST)
    linear_widening: float = constant(
        1.15, "1", "times the linear standard deviation where there is no profile"
    )
    profile_step: float = constant(1.5, "standard deviations", "first step of a profile", NUMERICS)
    profile_growth: float = constant(1.5, "1", "times the step before", NUMERICS)
    profile_shrink: float = constant(0.3, "1", "times a first step that was too long", NUMERICS)
    profile_steps: int = constant(5, "1", "each way", COST)
    profile_rise: float = constant(6.0, "chi2", "above the least met: far enough", NUMERICS)
    other_valley: float = constant(16.0, "chi2", "above the least met: another minimum", NUMERICS)
    foreseen: float = constant(
        0.5, "chi2", "reduction by a whole step, below which a fit of a profile is converged", COST
    )
    local_minima: float = constant(3.0, "chi2", "by which fits end higher or lower by chance")
    interval_widening: float = constant(
        1.5,
        "1",
        "times the standard deviation of a profile: how far estimates scatter",
        DEVELOPMENT,
    )
    missed_more: float = constant(
        4.0,
        "chi2",
        "by which the size that stays is missed more than the one that goes",
        DEVELOPMENT,
    )


FIT = FitTuning()
