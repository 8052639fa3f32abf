"""The machine as given, and what starts in it: each asked for once in a search."""

from collections.abc import Sequence
from functools import cached_property

from hannes.identification.diagnosis.global_starts import (
    Promised,
    faults_from_given,
    followed,
    global_fits,
    promised,
    worth_global_starts,
)
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import Fits, Progress, Start
from hannes.identification.diagnosis.score_test import screened_widely, shapes
from hannes.identification.diagnosis.shortlist import shortlist


class AsGiven:
    """The machine as given, and the starts in it, which one search asks for once.

    Another search, beside a better baseline, knows the fits from them.
    """

    def __init__(
        self, nominal: Linearisation, baseline: Linearisation, names: Sequence[str]
    ) -> None:
        self.nominal, self.names = nominal, names
        self._baseline, self._started = baseline, False
        self._global_fits: Fits | None = None

    @cached_property
    def promised(self) -> Promised:
        """What the effects of these names promise."""
        return promised(self.nominal, self._baseline, self.names)

    def global_fits(self, baseline: Linearisation, progress: Progress) -> Fits:
        """Fits from global starts below a baseline; of faults alone where others take too much."""
        if self._global_fits is None:
            given = self.nominal, baseline, self.names, progress
            if worth_global_starts(baseline):
                self._global_fits = global_fits(*given, self.promised)
            else:
                self._global_fits = faults_from_given(*given)
        for name, point in self._global_fits.items():
            self._global_fits[name] = followed(point, baseline.chi2)
        return dict(self._global_fits)

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
