"""Constants of the verdict: what a name needs, what speaks against it, and the next run."""

from dataclasses import dataclass

from hannes.identification.remainder import STATED_RUNS
from hannes.identification.tuning_table import CONVENTION, COST, DEVELOPMENT, constant


@dataclass(frozen=True)
class VerdictTuning:
    """When an effect is named, and with what reservation."""

    false_alarms: float = constant(
        0.02,
        "1",
        "of machines that lack nothing, on which the name limit aims to name something",
        DEVELOPMENT,
    )
    clean: float = constant(
        1.3, "chi2 per bin", "that a complete model leaves at most", DEVELOPMENT
    )
    agrees: float = constant(
        1.15, "chi2 per bin", "that an agreeing nominal model leaves at most", DEVELOPMENT
    )
    nearest: int = constant(3, "1", "candidates that are said to come nearest to an unknown")
    explained_share: float = constant(
        0.8, "1", "of what can be explained, for a name beside a remainder", DEVELOPMENT
    )
    common_share: float = constant(
        0.5,
        "1",
        "of a pair's reduction, that the effect common to all near pairs needs",
        DEVELOPMENT,
    )
    heldout_increase: float = constant(
        4.0, "chi2", "of the held-out runs, that a name may add: refits differ by that", DEVELOPMENT
    )
    heldout_share: float = constant(0.05, "1", "of its reduction, if that is more", DEVELOPMENT)
    heldout_most: float = constant(12.0, "chi2", "that it may add in any case", DEVELOPMENT)
    heldout_shown: float = constant(
        8.0,
        "chi2",
        "of the held-out runs, that shows an effect by itself: by chance they lose by one",
        DEVELOPMENT,
    )
    doubt: float = constant(
        14.0,
        "chi2",
        "reduction too small for a name, larger than chance",
        "sound hands of the quoted study of 737365f",
    )
    generic_limit: float = constant(16.0, "chi2", "the same of a generic disturbance", DEVELOPMENT)
    remainder: float = constant(
        8.0, "chi2", "reduction of a further effect that is mentioned", DEVELOPMENT
    )
    trend_limit: float = constant(
        36.0, "chi2", "reduction of a trend across runs that is stated", DEVELOPMENT
    )
    trend_beside_name: float = constant(12.0, "chi2", "the same beside a clean name", DEVELOPMENT)
    beyond_range: float = constant(
        4.0,
        "chi2",
        "that a step beyond an end of its range would reduce, to doubt an effect",
        DEVELOPMENT,
    )
    prior_p_value: float = constant(
        0.005, "1", "of a machine so far from its nominal values", DEVELOPMENT
    )
    fewest_repeats: int = constant(3, "1", "runs that show a trend", "least that shows one")
    assumed_weight: float = constant(
        STATED_RUNS, "runs", "that the assumed run-to-run variability counts for against repeats"
    )
    trend_within: float = constant(7.0, "chi2", "that runs under one command must show of a trend")
    slow_components: tuple[int, ...] = constant(
        (8, 24), "1", "slowest cosine components that are tested; the rest is taken as noise"
    )
    residual_p_value: float = constant(
        0.001,
        "1",
        "of a residual test over all channels: at 0.01 three of 45 sound hands were `unknown`",
        "sound hands of the quoted study of 737365f",
    )
    heldout_steps: int = constant(3, "1", "of the fits without the held-out runs", COST)
    compared: int = constant(8, "1", "effects in the table of confusability", "room on the page")
    least_separation: float = constant(
        2.0, "standard deviations", "of two explanations, for which a run is proposed", CONVENTION
    )
    enough_separation: float = constant(
        5.0, "standard deviations", "with which no further channel is asked for", CONVENTION
    )
    worth_logging: float = constant(
        1.0, "standard deviations", "that further channels must add", CONVENTION
    )


VERDICT = VerdictTuning()
