"""Constants of the search: which effects are refitted, from where, and how often."""

from dataclasses import dataclass

from hannes.identification.tuning_table import COST, DEVELOPMENT, NUMERICS, constant


@dataclass(frozen=True)
class SearchTuning:
    """How the catalogue is searched."""

    most_simulated: float = constant(
        24_000.0, "s", "of single runs in one diagnosis, whose search then ends: some 80 s", COST
    )
    rivals_simulated: float = constant(
        700.0, "s", "likewise, of what could stand in for effects whose search was ended", COST
    )
    closing_simulated: float = constant(
        2_000.0, "s", "likewise, of what judges a search for further effects that was ended", COST
    )
    needed_runs: float = constant(
        130.0, "weighted runs", "of each command that every verdict needs, whatever was spent", COST
    )
    needed_per_parameter: float = constant(
        6.0, "runs", "likewise, for each uncertain parameter of the machine", COST
    )
    exact_weight: float = constant(
        2.5, "1", "of a run with the sampled controller among these", COST
    )
    alike_weight: float = constant(
        0.31, "1", "of each of some runs side by side by the same steps among these", COST
    )
    alike_call: float = constant(0.8, "runs", "as which all of them count beside that", COST)
    shortlist: int = constant(5, "1", "effects of each screening that are refitted", COST)
    faint: float = constant(
        6.0, "chi2", "reduction below which an effect is not refitted", DEVELOPMENT
    )
    biased_baseline: float = constant(
        1.3, "chi2 per bin", "of a baseline that may be biased by the missing effect", DEVELOPMENT
    )
    explained: float = constant(
        0.85,
        "chi2 per bin",
        "that a fit leaves which explains all: then nothing starts in the machine as given",
        DEVELOPMENT,
    )
    likely_faults: int = constant(2, "1", "faults of like parts that are refitted, at most", COST)
    name_limit: float = constant(
        16.0,
        "chi2",
        "reduction for which an effect is named: chance gives that once in 300 campaigns",
    )
    simulated_price: float = constant(
        4.0,
        "chi2",
        "subtracted where noise is simulated: it is not right to less",
        "sound hands of the quoted study of 737365f",
    )
    parameter_price: float = constant(
        6.0, "chi2", "of each parameter of an effect beyond its first", DEVELOPMENT
    )
    fault_price: float = constant(
        8.0,
        "chi2",
        "of a fault of one of like parts: twenty are tried, and parts differ by themselves",
        DEVELOPMENT,
    )
    generic_price: float = constant(
        1.5,
        "chi2",
        "the same of a generic disturbance: about what chance gives a parameter",
        DEVELOPMENT,
    )
    generic_reach: float = constant(
        0.6,
        "1",
        "of an effect's reduction: a generic disturbance that promises less is not refitted",
        COST,
    )
    rival: float = constant(
        10.0, "chi2", "within which a rival is not separated from the best", DEVELOPMENT
    )
    nested_chance: float = constant(
        0.05,
        "1",
        "that further numbers of a generic disturbance fit so much better: then no law stands",
        "convention",
    )
    nested_limit: float = constant(
        3.0,
        "times a name's limit",
        "chi-squared reduction that a law needs which fits no better than such a disturbance",
        DEVELOPMENT,
    )
    rival_share: float = constant(
        0.08,
        "1",
        "of the best reduction, likewise: no model is right to more than that",
        DEVELOPMENT,
    )
    left_again: float = constant(
        4.0,
        "1",
        "times what the best one leaves above noise: a rival that leaves so much more is none",
    )
    second_share: float = constant(
        0.04, "1", "of the reduction, for what else is indicated to count", DEVELOPMENT
    )
    further_share: float = constant(
        0.0005, "1", "of what some effects explain, for one more: no law is right to more than that"
    )
    share_of_rest: float = constant(
        0.6,
        "1",
        "of what some effects leave above noise, for one more, where that is less",
        DEVELOPMENT,
    )
    sure_beside: float = constant(
        80.0,
        "chi2",
        "that one more needs at most, where they leave little; below, held-out runs are asked",
        DEVELOPMENT,
    )
    most_effects: int = constant(4, "1", "effects that are named together", COST)
    refused_effects: int = constant(
        1, "1", "that do not stay beside some that leave much: then one more is tried", COST
    )
    further_starts: int = constant(3, "1", "further effects that are refitted at a time", COST)
    surely_missed: float = constant(
        120.0, "chi2", "that an effect is missed by in the linearisation: it is not left out", COST
    )
    missed_much: float = constant(
        3.0, "1", "times what a further effect needs: likewise, whichever is more", COST
    )
    stand_in_share: float = constant(
        0.6, "1", "of what an effect explains: another that may do that is refitted in its place"
    )
    stand_ins: int = constant(2, "1", "of these for each effect, at most", COST)
    much_left: float = constant(
        0.05, "1", "of what effects explain, still left: then some are started together", COST
    )
    joint_starts: int = constant(2, "1", "sets of effects that are started together", COST)
    penalties: int = constant(40, "1", "of a path of the lasso, in equal ratios", NUMERICS)
    least_penalty: float = constant(1e-3, "1", "of the first, at its end", NUMERICS)
    sweeps: int = constant(100, "1", "of coordinate descent at each penalty, at most", NUMERICS)
    other_minimum: float = constant(2.0, "chi2", "by which another baseline is a better one")
    confusable_cosine: float = constant(
        0.95, "1", "of two signatures that these recordings hardly separate", "convention"
    )
    screening_sizes: tuple[float, ...] = constant(
        (1.0, 2.0, 4.0, 8.0, 16.0, 29.0, 59.0, -2.0, -4.0, -8.0, -16.0, -29.0),
        "steps",
        "of a screening for large effects",
        COST,
    )
    near_sizes: tuple[float, ...] = constant(
        (1.0, 0.2),
        "steps",
        "of a screening beside a baseline: with contacts a larger one may be another signature",
        DEVELOPMENT,
    )
    fault_sizes: tuple[float, ...] = constant(
        (1.0, 8.0, 25.0, -8.0, -25.0, -44.0),
        "steps",
        "the same of faults of like parts: a stop may be reached from its range's end on alone",
        COST,
    )
    sizes_beside: tuple[float, ...] = constant(
        (1.0, 8.0, 29.0, 59.0, -8.0, -29.0), "steps", "the same beside other effects", COST
    )
    secant_range: float = constant(3.0, "1", "times a secant's size within which it is believed")
    shapes: int = constant(5, "1", "values tried of a shape parameter", COST)
    guess_shares: tuple[float, ...] = constant(
        (1.0, 0.5, 0.2, 0.05), "1", "of a guess, of which the best starts a fit", COST
    )
    hopeless: float = constant(
        0.05, "1", "of another effect's reduction: a guess at the baseline below is no rival", COST
    )
    hopeless_as_given: float = constant(
        0.3, "1", "the same of a guess at the machine as given, which is less biased", COST
    )
    final_fits: int = constant(3, "1", "fits refined with new derivatives", COST)
    final_share: float = constant(0.5, "1", "of the largest reduction that such a fit has", COST)
    kept_guess: float = constant(
        0.7, "1", "of a guess's reduction: a fit with less may be in a local minimum"
    )
    slight: float = constant(
        64.0,
        "chi2",
        "reduction up to which an effect hardly biases the baseline, which is refitted first",
        DEVELOPMENT,
    )
    far_reduction: float = constant(10.0, "chi2", "of one refinement: likewise")
    far_share: float = constant(0.05, "1", "of the reduction, if that is more")
    crossed_share: float = constant(
        0.6,
        "1",
        "of the best reduction: such a rival is refitted from the best one's machine",
        DEVELOPMENT,
    )
    like_share: float = constant(
        0.8, "1", "of the best reduction: a like fault led by a worse one starts from the best too"
    )
    takeover_shares: tuple[float, ...] = constant(
        (0.0, 0.5, 1.0), "1", "of a removed effect's work that other parameters take over", NUMERICS
    )
    fading_shares: tuple[float, ...] = constant(
        (0.75, 0.5, 0.25, 0.0), "1", "of an effect that is removed gradually", NUMERICS
    )
    last_round_share: float = constant(
        0.005, "1", "of the whole reduction: a round with less is the last", COST
    )
    size_dependent_cosine: float = constant(
        0.3,
        "1",
        "of a small and a large signature, below which the effect starts globally",
        DEVELOPMENT,
    )
    rounds_behind: float = constant(
        3.0, "1", "rounds as good as its last one, within which a like fault reaches the best", COST
    )
    large_size: float = constant(8.0, "steps", "of the large signature")
    every_size: tuple[float, ...] = constant(
        tuple(map(float, range(1, 30))),
        "steps",
        "both ways, at which a size-dependent effect starts: valleys are narrow",
    )
    apart: tuple[float, float] = constant((2.0, 0.3), "steps, share", "between starts", COST)
    global_sizes: tuple[float, ...] = constant(
        (2.0, 4.0, 6.0, 9.0, 14.0), "steps", "the same of other effects", COST
    )
    few_sizes: tuple[float, ...] = constant(
        (2.0, 6.0, 14.0), "steps", "the same, which decide whether an effect is started so", COST
    )
    far_sizes: tuple[float, ...] = constant(
        (29.0, 44.0), "steps", "likewise, of faults of like parts beside these", COST
    )
    halvings: int = constant(2, "1", "of the distance to the sizes about a fault's best one", COST)
    promising: float = constant(
        0.15,
        "1",
        "of the most that one promises: with less an effect is not looked at larger",
        COST,
    )
    own_part: float = constant(
        0.01,
        "1",
        "of a signature, squared: where the machine's values absorb all but that",
        DEVELOPMENT,
    )
    lost_baseline: float = constant(
        3.0,
        "chi2 per bin",
        "of a baseline beside which likely effects start globally too",
        DEVELOPMENT,
    )
    far_away: float = constant(
        10.0,
        "standard deviations",
        "of a value of the machine: such a baseline that leaves far too much is not followed",
        DEVELOPMENT,
    )
    little_work: float = constant(
        100.0, "s", "of simulated runs in a round of derivatives: then it is followed", COST
    )
    much_work: float = constant(
        500.0, "s", "likewise: from there on faults alone start globally beside a good fit", COST
    )
    little_left: float = constant(1.15, "chi2 per bin", "that such a fit leaves", COST)
    found_again: float = constant(
        0.5,
        "1",
        "of such a baseline, below which an effect leads to a machine that noise is estimated at",
        DEVELOPMENT,
    )
    further_from_best: float = constant(
        2.0, "1", "times what the best one leaves: a fit with more is not refitted there", COST
    )
    likely_effects: int = constant(3, "1", "that do so", COST)
    likely_when_lost: int = constant(
        4, "1", "of all effects that start globally there: another comes in beside the first", COST
    )
    starts_tried: int = constant(3, "1", "sizes with the best linear guess that are fitted", COST)
    start_steps: int = constant(2, "1", "steps of each", COST)
    starts_kept: int = constant(2, "1", "of these that are fitted further", COST)
    far_above: float = constant(
        10.0, "1", "times what another effect leaves, above which one is no rival of it", COST
    )
    further_steps: int = constant(5, "1", "steps of each", COST)
    neighbour_sizes: tuple[float, ...] = constant(
        (0.8, 0.9, 1.1, 1.25), "1", "times the size found, where a deeper minimum is looked for"
    )
    neighbour_rounds: int = constant(3, "1", "of that, at most", COST)
    deeper: float = constant(2.0, "chi2", "by which a minimum is deeper")
    deeper_share: float = constant(
        0.1, "1", "of what is left beyond noise, likewise: with less it is the last round", COST
    )


SEARCH = SearchTuning()
