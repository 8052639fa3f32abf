"""Every tuning constant of the diagnosis, in one frozen dataclass for each of its seven stages."""

from hannes.identification.diagnosis.tuning.fit import FIT, FitTuning
from hannes.identification.diagnosis.tuning.noise import NOISE, NoiseTuning
from hannes.identification.diagnosis.tuning.onset import ONSET, OnsetTuning
from hannes.identification.diagnosis.tuning.probability import PROBABILITY, ProbabilityTuning
from hannes.identification.diagnosis.tuning.search import SEARCH, SearchTuning
from hannes.identification.diagnosis.tuning.shape import SHAPE, ShapeTuning
from hannes.identification.diagnosis.tuning.verdict import VERDICT, VerdictTuning

__all__ = [
    "FIT",
    "NOISE",
    "ONSET",
    "PROBABILITY",
    "SEARCH",
    "SHAPE",
    "VERDICT",
    "FitTuning",
    "NoiseTuning",
    "OnsetTuning",
    "ProbabilityTuning",
    "SearchTuning",
    "ShapeTuning",
    "VerdictTuning",
]
