"""What of the reducible gap is left on the test recordings, before and after, beside the truth.

Beside recordings a gap that is small against the spread of repeats cannot be measured. Here the
test runs are simulated again by the same hand, with and without the hidden effect, on the same
noise. Their difference d is the gap that the effect makes. Of it d' C^-1 d is reducible. C holds
noise, run-to-run variability, and all parameters by their uncertainty: what other values of the
machine explain as well does not count. What the named effects do in the library's hand is
subtracted from d for what is left. The factors are means over runs that share no noise.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.naming_study.draw import Drawn
from benchmarks.truth.expected import expected
from benchmarks.truth.protocol import Protocol
from hannes.campaigns.campaign import Campaign
from hannes.identification.diagnosis.campaign_diagnosis import Result
from hannes.identification.diagnosis.linearisation import differenced
from hannes.identification.diagnosis.noise_covariance import (
    NoiseAccuracy,
    NoiseCovariance,
    estimated_noise,
)
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.simulator import Model

ACCURACY = NoiseAccuracy(2.0, 4)
DRAWS = 2  # runs of a mean
Runs = Mapping[str, Sequence[Mapping[str, np.ndarray]]]  # condition -> runs: channel -> samples


def left(
    campaign: Campaign, found: Result, case: Drawn, plan: Protocol, seed: int
) -> dict[str, float]:
    """Reducible gap that the hidden effect makes (`before`), less what was named (`after`).

    In squared standard deviations. Raises RuntimeError where the truth does not end.
    """
    base = found.found.baseline.x
    whole = found.found.baseline.model
    groups = grouped(whole.small, campaign.of("show"))
    model = Model(whole.small, groups, whole.space, (), bandwidth=whole.bandwidth)
    model.whole = whole.whole
    model = model.with_sampling_correction(found.decision.point.x, found.decision.effects)
    names = [group.entries[0].condition for group in model.groups]
    runs = [expected(plan, seed, hidden, names, 2 * DRAWS) for hidden in (case.hidden, {})]
    gap = [_apart(model, *(_some(each, k) for each in runs)) for k in range(2)]
    named = _named(model, found)
    _, derivatives = differenced(model, base, model.space.uncertain, False)
    noise = estimated_noise(model, base, ACCURACY, 0)
    rest = [[d - e for d, e in zip(each, named, strict=True)] for each in gap]
    return {"before": _size(noise, derivatives, *gap), "after": _size(noise, derivatives, *rest)}


def _some(runs: Runs, first: int) -> Runs:
    return {name: each[first::2] for name, each in runs.items()}


def _apart(model: Model, real: Runs, without: Runs) -> list[np.ndarray]:
    """Difference of bin means of each group, mean over runs."""
    return [
        np.mean(
            [
                group.vector(one) - group.vector(other)
                for one, other in zip(real[name], without[name], strict=True)
            ],
            axis=0,
        )
        for group, name in ((group, group.entries[0].condition) for group in model.groups)
    ]


def _named(model: Model, found: Result) -> list[np.ndarray]:
    """What the result's effects do to each group."""
    places = np.array([found.decision.point.x, found.decision.point.x])
    places[1, model.space.uncertain.size :] = 0.0
    made = [model.vectors(group, places, True) for group in model.groups]
    return [each[0] - each[1] for each in made]


def _size(
    noise: NoiseCovariance,
    derivatives: list[np.ndarray],
    one: list[np.ndarray],
    other: list[np.ndarray],
) -> float:
    """d' C^-1 d of two means d of the same."""
    columns, a, b = (noise.together(each) for each in (derivatives, one, other))
    projected = np.linalg.solve(np.eye(len(columns)) + columns @ columns.T, columns @ b)
    return float(a @ b - (columns @ a) @ projected)
