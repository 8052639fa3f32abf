"""Constants of the probabilities: what is expected before any recording, and how laws err."""

from dataclasses import dataclass

from hannes.identification.tuning_table import DEVELOPMENT, constant


@dataclass(frozen=True)
class ProbabilityTuning:
    """How probable each explanation is before recordings are seen, and what they are worth."""

    nothing: float = constant(0.45, "1", "that nothing is missing, before any recording", "choice")
    something_else: float = constant(
        0.05, "1", "likewise, that what is missing is in no catalogue", "choice"
    )
    further: float = constant(
        0.3, "1", "likewise, that one more effect is there beside some", "choice"
    )
    first_price: float = constant(
        5.0, "chi2", "of an effect's first parameter: its size is not known before", DEVELOPMENT
    )
    law_error: float = constant(
        0.008, "1", "of what is explained: laws err by that, and likelihoods count for less"
    )
    law_share: float = constant(
        0.1, "1", "of what is explained, that a right law may leave above noise", DEVELOPMENT
    )
    shape_price: float = constant(
        16.0, "chi2", "of a law of any shape, which explains all above noise", DEVELOPMENT
    )
    refused: float = constant(
        0.7, "1", "of its probability, that an effect keeps which is not believed", DEVELOPMENT
    )
    least_nothing: float = constant(
        0.6,
        "1",
        "that nothing is missing, at least, where that is the verdict",
        "chosen after the quoted study: 99 of 100 such verdicts were of sound hands",
    )
    least_else: float = constant(
        0.2,
        "1",
        "that something in no catalogue is missing, at least, where the verdict is unknown",
        "chosen after the quoted study: seven of eleven such verdicts were of sound hands",
    )
    beside_power: float = constant(
        8.0,
        "1",
        "of the share that effects explain: how probable it is that they are there beside "
        "something else, and not led there by it",
        DEVELOPMENT,
    )
    shown: float = constant(0.01, "1", "probability from which an explanation is listed")


PROBABILITY = ProbabilityTuning()
