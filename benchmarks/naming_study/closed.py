"""What of the reducible gap is left on the show recordings, before and after, beside the truth.

Beside recordings a gap that is small against what repeats differ by cannot be told. Here the show
runs are made once more, by the same hand, and nothing differs between them but noise; the refitted
base, and the result, simulate them too. Reducible is what of a difference no other values of the
machine explain: d' C^-1 d over bin means, C of noise, of what differs from run to run, and of all
parameters by how far they may be off. Noise has no part in it: both factors d are means over runs
that have no noise in common. A floor remains, which refitted bases of empty hands leave.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.naming_study.draw import Drawn
from benchmarks.truth.expected import expected
from benchmarks.truth.protocol import Protocol
from hannes.campaign import Campaign
from hannes.diagnosis.deep import Result
from hannes.diagnosis.groups import Group, grouped
from hannes.diagnosis.model import Model
from hannes.diagnosis.point import Care, Ground, differenced, surveyed

CARE = Care(2.0, 6)
DRAWS = 3  # runs of a mean
Means = Sequence[list[np.ndarray]]  # two: bin means of all groups


def left(
    campaign: Campaign, found: Result, case: Drawn, plan: Protocol, seed: int
) -> dict[str, float]:
    """Reducible gap of the refitted base (`before`) and of the result (`after`).

    In squared standard deviations. Raises RuntimeError where the truth does not end.
    """
    whole = found.found.base.ground.model
    model = Model(whole.small, grouped(whole.small, campaign.of("show")), whole.space, ())
    model.whole = whole.whole
    model = model.ticking(found.found.base.x, found.choice.effects)
    names = [group.entries[0].condition for group in model.groups]
    runs = expected(plan, seed, case.hidden, names, 2 * DRAWS)
    truth = [
        [_mean(group, runs[name][k::2]) for group, name in zip(model.groups, names, strict=True)]
        for k in range(2)
    ]
    places = np.array([found.found.base.x, found.choice.point.x])
    return dict(zip(("before", "after"), _left(model, places, truth), strict=True))


def _mean(group: Group, runs: Sequence[Mapping[str, np.ndarray]]) -> np.ndarray:
    return np.mean([group.vector(each) for each in runs], axis=0)


def _left(model: Model, places: np.ndarray, truth: Means) -> list[float]:
    """Reducible gap of each of the places x, shape (m, size)."""
    _, slopes = differenced(model, places[0], model.space.uncertain, False)
    grounds = [surveyed(model, places[0], slopes, CARE, seed) for seed in range(2)]
    columns = grounds[0].together(slopes)
    curvature = np.eye(len(columns)) + columns @ columns.T
    made = [model.vectors(group, places, True) for group in model.groups]
    gaps = []
    for k in range(len(places)):
        one, other = (
            grounds[0].together(_apart([each[k] for each in made], ground, mean))
            for ground, mean in zip(grounds, truth, strict=True)
        )
        told = np.linalg.solve(curvature, columns @ other)
        gaps.append(float(one @ other - (columns @ one) @ told))
    return gaps


def _apart(made: list[np.ndarray], ground: Ground, truth: list[np.ndarray]) -> list[np.ndarray]:
    return [t - m - grain for m, grain, t in zip(made, ground.grain, truth, strict=True)]
