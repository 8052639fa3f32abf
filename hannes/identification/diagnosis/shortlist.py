"""Which guesses of a screening are fitted: the best few, and large ones in the machine as given."""

from collections.abc import Sequence

from hannes.identification.diagnosis.global_starts import Promised
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import Start
from hannes.identification.diagnosis.score_test import Guess, screened_widely, shapes
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.plants.part_fault import part_faults


class AsGiven:
    """The machine as given, and the starts in it, which one search asks for once.

    Another search, beside a better baseline, knows the fits from them.
    """

    def __init__(self, nominal: Linearisation, promised: Promised) -> None:
        self.nominal, self.promised, self._started = nominal, promised, False

    def large(self, names: Sequence[str]) -> list[Start]:
        """Starts with each effect at sizes to the end of its range; none the second time.

        One that promises far less than another at any of a few sizes is not among them, unless it
        has a shape: one shape says nothing of the others.
        """
        if self._started:
            return []
        effects, some = self.nominal.space.effects, self.promised
        chosen = [
            name
            for name in names
            if some.most <= 0.0 or len(shapes(effects[name])) > 1 or some.promising(name)
        ]
        guesses = screened_widely(self.nominal, chosen)
        self._started = True
        return [(self.nominal, guess) for guess in shortlist(self.nominal, guesses)]


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
