"""The effects found once more in the machine as given, alone and with others beside them.

Where something more is there, a fit moves the machine to follow it. There it shows no more, and
what gains is another effect or nothing. The machine as given is not moved. With the effects that
are known in it, what is left shows the others.
"""

from collections.abc import Iterator, Sequence

from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.joint_starts import started_together
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import Progress, started_as_given
from hannes.identification.diagnosis.score_test import SMALL, screened_widely
from hannes.identification.diagnosis.trials import Joint, SearchResult, Trial
from hannes.identification.diagnosis.tuning import SEARCH


def surely_there(joint: Joint) -> tuple[str, ...]:
    """The effects that are missed by much; others may stand for what is not found yet."""
    return tuple(n for n in joint.trial.effects if joint.losses[n] >= SEARCH.surely_missed)


def restarted(found: SearchResult, trial: Trial, progress: Progress) -> Trial | None:
    """The effects of a trial, refitted from the machine as given; None where that fails."""
    start = _started(found, trial.effects, trial.point, progress)
    if start is None:
        return None
    return Trial(trial.effects, settled(fitted(start, SEARCH.further_steps)), 0.0)


def enlarged_as_given(
    found: SearchResult, effects: Sequence[str], point: Linearisation, progress: Progress
) -> Iterator[Trial]:
    """These effects with those that enter first beside them, refitted from there.

    point: a fit with them, whose sizes they have
    """
    if len(effects) >= SEARCH.most_effects:
        return
    start = _started(found, effects, point, progress)
    if start is None:
        return
    names = [name for name in start.space.effects if name not in (*effects, *GENERIC)]
    guesses = screened_widely(start, names, SEARCH.sizes_beside, SMALL)
    counts = range(1, SEARCH.most_effects - len(effects) + 1)
    for more, fit in started_together([(start, guesses)], progress, counts):
        yield Trial((*effects, *more), fit, 0.0)


def _started(
    found: SearchResult, effects: Sequence[str], point: Linearisation, progress: Progress
) -> Linearisation | None:
    some = " and ".join(effects) or "no effect"
    progress(f"{some}, in the machine as given".replace("_", " "))
    return started_as_given(found.nominal, point, effects)
