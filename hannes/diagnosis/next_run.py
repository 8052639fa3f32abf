"""The run most worth recording next: the one on which two explanations differ most.

Each proposed run is simulated with both, as they fit what is recorded; their difference counts in
standard deviations of what is not known there: sensors, firmware, run to run, and of the machine
what the recordings so far leave open.
"""

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from hannes.campaign import Entry
from hannes.diagnosis.groups import Group
from hannes.diagnosis.investigation import Found, Trial
from hannes.diagnosis.model import Model
from hannes.diagnosis.point import Point, differenced, run_to_run
from hannes.plant import Plant
from hannes.recording import Recording

WORTH = 2.0  # standard deviations: a run that tells less is not proposed
Proposals = Callable[[Mapping[str, Recording]], Mapping[str, Recording]]


def next_run(plant: Plant, found: Found, entries: Iterable[Entry]) -> dict | None:
    """The run to record next, what it tells apart, and why; None where none is worth it.

    A plant may lack `proposals`.
    """
    proposals: Proposals | None = getattr(plant, "proposals", None)
    every = [*found.trials, *([found.anything] if found.anything else [])]
    pair = sorted(every, key=lambda each: -each.gain)[:2]
    if proposals is None or len(pair) < 2:
        return None
    told = {
        name: separation(found.base, Group(plant, [Entry(name, recording, name)]), *pair)
        for name, recording in proposals({e.condition: e.recording for e in entries}).items()
    }
    best = max(told, key=lambda name: told[name], default="")
    if not best or told[best] < WORTH:
        return None
    names = [trial.effects[0] for trial in pair]
    apart = " from ".join(name.replace("_", " ") for name in names)
    return {
        "experiment": best,
        "separates": names,
        "why": f"it would tell {apart} by {told[best]:.1f} standard deviations",
    }


def separation(base: Point, group: Group, one: Trial, other: Trial) -> float:
    """Distance between two explanations of one more run, in standard deviations."""
    there = base.ground.model
    model = Model(there.small, [group], there.space, ())
    model.whole = there.whole
    for trial in (one, other):
        model = model.ticking(trial.point.x, trial.effects)
    known = there.space.uncertain
    vectors, slopes = differenced(model, base.x, known, False)
    ends = model.vectors(group, np.array([one.point.x, other.point.x]), True)
    channels = model.simulated(group, base.x[np.newaxis], False)[0]
    if channels is None or not (np.isfinite(ends).all() and np.isfinite(vectors[0]).all()):
        return 0.0
    rows, jerk = run_to_run(model, group, slopes[0], channels), group.jerk(channels)
    open_left = np.linalg.solve(base.curvature[: known.size, : known.size], slopes[0])
    doubt = (
        base.ground.noise.covariance(group)
        + np.diag((base.ground.noise.jerk * jerk) ** 2)
        + rows.T @ rows
    )
    difference = ends[0] - ends[1]
    return float(np.sqrt(difference @ np.linalg.solve(doubt + slopes[0].T @ open_left, difference)))
