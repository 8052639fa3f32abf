"""Every tuning constant of the calibration, with unit, meaning and how it was chosen."""

from dataclasses import dataclass

from hannes.identification.tuning_table import CONVENTION, COST, NUMERICS, constant


@dataclass(frozen=True)
class CalibrationTuning:
    """How a calibration searches, and what its intervals and labels mean."""

    difference_step: float = constant(
        0.5, "standard deviations", "of a difference: the slope over where a parameter may lie"
    )
    least_step: float = constant(3e-4, "scales", "least difference step", NUMERICS)
    largest_step: float = constant(3e-2, "scales", "largest difference step", NUMERICS)
    first_step: float = constant(2e-3, "scales", "difference step before any fit", NUMERICS)
    start_shift: float = constant(1e-3, "s", "by which a start time is differenced", NUMERICS)
    same_derivatives: float = constant(0.03, "scales", "within which derivatives are reused", COST)
    same_slow_derivatives: float = constant(
        0.15, "scales", "likewise of run-to-run and uncertain parameters", COST
    )
    at_bound: float = constant(1e-5, "scales", "from a bound, where a value counts as on it")
    short_step: float = constant(
        0.1, "standard deviations", "of the next step, where a search ends", NUMERICS
    )
    max_evaluations: int = constant(40, "1", "residuals of one search", COST)
    fine_tolerance: float = constant(1e-5, "1", "relative, of scipy's least_squares", NUMERICS)
    coarse_tolerance: float = constant(
        0.1, "1", "of the first round, whose weights are provisional", COST
    )
    robust_scale: float = constant(
        2.0, "standard deviations", "beyond which a robust loss grows less"
    )
    nonlinearity: float = constant(
        10.0, "1", "times the within-bin nonlinearity that is taken as noise"
    )
    joint_steps: int = constant(4, "1", "of all parameters at once, in a round", COST)
    longest_step: float = constant(0.05, "scales", "of them", NUMERICS)
    missing_feature: float = constant(
        10.0, "standard deviations", "residual of a feature that a simulation does not have"
    )
    max_rounds: int = constant(6, "1", "of search and reweighting", COST)
    still: float = constant(
        0.3, "standard deviations", "that the last round may move a parameter", NUMERICS
    )
    as_good: float = constant(1.001, "1", "times the least cost: the first such start is kept")
    agreeing_cost: float = constant(1.01, "1", "times the least cost, of a start that agrees")
    agreeing_distance: float = constant(0.5, "half-widths", "of a start that agrees")
    start_reach: float = constant(0.25, "scales", "of the box of starting points, at most")
    scanned_points: int = constant(64, "1", "where features ask for a global start", COST)
    weak_prior: float = constant(
        0.5, "1", "relative standard deviation of a value about which nothing was stated"
    )
    start_rounds: int = constant(3, "1", "that align a prediction in time", NUMERICS)
    level: float = constant(0.95, "1", "of an interval", CONVENTION)
    shrinkage: float = constant(12.0, "runs", "that count for equal influence of all conditions")
    least_freedom: float = constant(
        1.2, "degrees of freedom", "below which one run alone decides a parameter"
    )
    no_information: float = constant(1e-6, "1", "of the prior's: such a parameter moves nothing")
    max_partners: int = constant(3, "1", "parameters named as confounded with one")
    explained_variance: float = constant(0.75, "1", "of a variance, that partners explain")
    least_partner: float = constant(0.3, "1", "of a variance, that one partner explains")
    least_value: float = constant(0.1, "scales", "to which a half-width is relative at least")
    not_parabolic: float = constant(0.25, "1", "relative difference that calls for a profile")
    profile_trials: int = constant(3, "1", "on each side", COST)
    widest_profile: float = constant(3.0, "1", "times the linear half-width, at most", NUMERICS)
    permutations: int = constant(999, "1", "random signs of the test for repeats", COST)
    repeat_p_value: float = constant(0.05, "1", "of a residual that repeats", CONVENTION)
    spread_p_value: float = constant(
        0.01, "1", "of a mean beyond the spread of repeats", CONVENTION
    )
    misleading_ratio: float = constant(
        3.0, "1", "mean residual over what repeats leave, from which no interval is trusted"
    )
    absent_ratio: float = constant(
        1.6, "1", "the same, which must have shown for absence to be stated"
    )
    missing_p_value: float = constant(
        0.02, "1", "that chance gives as much to any effect: from it the model counts as wrong"
    )
    far_p_value: float = constant(
        0.001, "1", "that chance takes a value so far from the given one: from it one is wrong"
    )
    effect_step: float = constant(
        1.0 / 60.0, "1", "of its range, by which an effect is differenced", NUMERICS
    )
    repeat_share: float = constant(0.25, "1", "of the residual, that must repeat to be stated")


CALIBRATION = CalibrationTuning()
