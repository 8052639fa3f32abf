"""Constants of the noise model: its covariance over time, and how far runs differ."""

from dataclasses import dataclass

from hannes.identification.tuning_table import COST, DEVELOPMENT, NUMERICS, constant


@dataclass(frozen=True)
class NoiseTuning:
    """How the covariance of bin means is estimated."""

    antedependence_order: int = constant(8, "bins", "earlier bins that a bin is regressed on")
    antedependence_window: int = constant(
        5,
        "bins",
        "on each side, pooled for one regression: few simulations say little about one bin",
    )
    windows_per_coefficient: int = constant(4, "1", "at least, of each regression coefficient")
    ridge: float = constant(1e-3, "1", "of the mean square of the regressors", NUMERICS)
    regression_floor: float = constant(
        1e-6, "1", "of a channel's mean square, that no earlier bin predicts", NUMERICS
    )
    coarse_nonlinearity: float = constant(
        10.0, "1", "times the within-bin nonlinearity taken as noise while a fit finds its way"
    )
    coarse_samples: int = constant(3, "1", "simulations averaged for it", COST)
    fine_nonlinearity: float = constant(
        1.0, "1", "times the within-bin nonlinearity taken as noise where a fit ends"
    )
    fine_samples: int = constant(40, "1", "simulations averaged for it", COST)
    proposed_samples: int = constant(20, "1", "simulations averaged for a proposed run", COST)
    repeats_nonlinearity: float = constant(
        2.0, "1", "the same, at least, where noise is known from repeats alone"
    )
    correlation_time: float = constant(0.6, "s", "over which noise of few runs is correlated")
    least_eigenvalue: float = constant(
        0.05, "1", "of the mean one: a covariance from few runs has none that is surely less"
    )
    least_white_of_many: float = constant(
        0.03, "1", "of a channel's roughness, which many simulations surely lack"
    )
    least_white_of_few: float = constant(
        0.1, "1", "of a channel's roughness, which few runs surely lack"
    )
    roughness_accuracy: float = constant(
        1.05, "1", "times the roughness of simulations: it is known no better"
    )
    profile_window: int = constant(5, "bins", "on each side, pooled for the noise of one bin")
    many_simulations: int = constant(20, "1", "of which correlation over time is estimated anew")
    contact_nudge: float = constant(
        0.1, "standard deviations", "of the machine's values, over which rounding is averaged"
    )
    correction_sizes: tuple[float, ...] = constant(
        (0.5, 3.0), "steps", "of an effect at which the sampled-controller correction is simulated"
    )
    correction_shares: tuple[float, ...] = constant(
        (0.5, 1.0, 1.5), "1", "times the size that an effect has, likewise"
    )
    fewest_simulations: int = constant(2, "1", "that must succeed", NUMERICS)
    nearer_controller: float = constant(
        0.9, "1", "of the distance that the stated controller leaves, for another to be taken"
    )
    counted_controller: float = constant(
        1.25, "1", "the same where positions are whole encoder counts, which firmware reads"
    )
    farthest_controller: float = constant(
        4.0, "1", "the same where that is not near, or the machine's values are nearer", DEVELOPMENT
    )
    continuous_controller: float = constant(
        1.3,
        "times what is not known of means",
        "that a continuous controller leaves at most where it is believed beside whole counts",
        DEVELOPMENT,
    )
    independent_values: float = constant(
        16.0,
        "1",
        "that such a distance is worth beside a machine's distance from its prior",
        DEVELOPMENT,
    )
    known_mean: float = constant(
        0.05, "squared noise floors", "to which a mean of repeats is known at most"
    )
    logged_periods: tuple[float, float] = constant(
        (2e-4, 5e-3), "s", "between which the interval of a log may be the controller's period"
    )
    alive: float = constant(
        20.0, "times its roughness", "range of a recorded channel that surely is not zero"
    )
    onset: float = constant(
        0.05,
        "s",
        "about a simulated touch, in which a finger may touch earlier than all others",
        DEVELOPMENT,
    )
    apart: float = constant(
        5.0, "times what repeats differ by", "at least, likewise: sensors drift at rest"
    )
    beside: float = constant(0.1, "1", "of the channel's largest range under any command, likewise")
    start_shift: float = constant(0.4e-3, "s", "by which a start time is differenced", NUMERICS)
    excess_ratios: tuple[float, ...] = constant(
        (0.25, 0.35, 0.5, 0.7, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0),
        "1", "times the assumed run-to-run variability, of which the likeliest is taken", NUMERICS,
    )  # fmt: skip
    excess_likelihood: float = constant(
        12.0, "1", "twice the log-likelihood ratio: two numbers by chance reach it once in 400",
        "chance of 1 in 400",
    )  # fmt: skip
    nearly_as_likely: float = constant(
        6.0,
        "1",
        "twice the log-likelihood that smaller variability may lose: of two numbers",
        "chance of 1 in 20",
    )
    wider_scatter: float = constant(
        2.0, "1", "times the assumed scatter where run-to-run variability was assumed too small"
    )
    widest_scatter: float = constant(0.2, "1", "to which scatter is widened at most", DEVELOPMENT)


NOISE = NoiseTuning()
