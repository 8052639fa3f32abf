"""Which guesses of a screening are fitted: the best few of them."""

from collections.abc import Sequence

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.score_test import Guess
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.plants.part_fault import part_faults


def shortlist(baseline: Linearisation, guesses: Sequence[Guess]) -> list[Guess]:
    """The best guesses, few of them faults of like parts: those are many and much alike."""
    faults = part_faults(baseline.space.effects, (each.effect for each in guesses))
    others = [each for each in guesses if each.effect not in faults][: SEARCH.shortlist]
    few = [each for each in guesses if each.effect in faults][: SEARCH.likely_faults]
    return [each for each in guesses if each in others or each in few]


def next_laws(baseline: Linearisation, guesses: Sequence[Guess]) -> list[Guess]:
    """The laws that the shortlist has no room for, as many again."""
    faults = part_faults(baseline.space.effects, (each.effect for each in guesses))
    laws = [each for each in guesses if each.effect not in faults]
    return laws[SEARCH.shortlist : 2 * SEARCH.shortlist]
