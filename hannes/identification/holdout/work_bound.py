"""How many simulations a diagnosis by hold-out may make at most: said before the first of them."""

from collections.abc import Sequence

from hannes.campaigns.segments import Segment
from hannes.core.effect import Effect
from hannes.identification.holdout.tuning import HOLDOUT
from hannes.plants.protocol import Plant, free_amplitudes

SHOWN = 16  # of each command: gaps, changes, the page
JUDGED = 2  # likewise of each effect, beside the baseline
TRACED = 3  # of each recording: as given, refitted, with what was found


def most_simulations(plant: Plant, segments: Sequence[Segment], tried: Sequence[Effect]) -> int:
    """Of all commands together: starting points, all fits, what judges and shows them."""
    free = sum(size > 0.0 for size in plant.free.values())
    own = [len(free_amplitudes(effect)) for effect in tried]
    present = sum(len(free_amplitudes(effect)) for effect in plant.effects)
    fits = 2 * _fit(free + present, present) + sum(_fit(free + present + n, n) for n in own)
    last = _fit(free + present, 0) + max((_fit(free + present + n, 0) for n in own), default=0)
    each = _starts(free) + fits + last + JUDGED * len(tried) + SHOWN
    commands = {plant.same_run(segment.recording) for segment in segments}
    return each * len(commands) + TRACED * len(segments)


def _fit(parameters: int, unknown: int) -> int:
    """Of one fit: its scan, then its residuals and the differences of its Jacobians."""
    steps = HOLDOUT.max_evaluations * (1 + 1 + 2 * parameters) + 1
    return 2 + len(HOLDOUT.scanned_sizes) * unknown + len(HOLDOUT.difference_steps) * steps


def _starts(free: int) -> int:
    """Of the starting points: steps as given and at other places, and these places."""
    alone = len(HOLDOUT.starts_alone)
    places = alone * free + 2**HOLDOUT.starts_together
    looked = 1 + HOLDOUT.starts_looked_at
    return 1 + places + looked * (1 + 2 * free) + alone * free
