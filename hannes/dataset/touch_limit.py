"""Commands that are limited from the touch on, as a grip policy limits them.

When a hand touches its object is known from the grasp alone. So such a grasp is simulated twice:
closed by the whole command, and then by one of which a share counts from the touch on. After a
while that share rises slowly, and the hand presses on.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hannes.dataset.sampling import SampledGrasp
from hannes.simulation.experiment.experiment import Reference
from hannes.simulation.trajectory import Grasp

TOUCH = 1.0  # N of force, from which it is touched
SETTLE, SPEED = 0.15, 2.0  # s until the share rises; rad/s at which the limit then does
BACK = 12.0  # rad/s at most by which the command goes back at the touch
STEP = 5e-3  # s between two set points


def is_limited(sampled: SampledGrasp) -> bool:
    """Whether the grasp's command is limited from the touch on."""
    return sampled.values.get("command.touch_share", 1.0) < 1.0


def limited(sampled: Sequence[SampledGrasp], free: Sequence[Grasp]) -> list[SampledGrasp]:
    """The grasps with their commands limited; `free`: the same, simulated by the whole command."""
    return [_limited(each, grasp) for each, grasp in zip(sampled, free, strict=True)]


def _limited(sampled: SampledGrasp, free: Grasp) -> SampledGrasp:
    touched = np.flatnonzero(free["force"] > TOUCH)
    if not touched.size:
        return sampled
    values, known = sampled.values, sampled.experiment
    seen = float(free.time[touched[0]]) + values.get("command.touch_delay", 0.0)
    times = np.arange(0.0, known.duration + STEP, STEP)
    wanted = np.interp(times, *known.reference.knots)
    angle = float(free["position"][touched[0]])
    beyond = np.maximum(wanted - angle, 0.0)
    first = values["command.touch_share"]
    last = max(values.get("command.press_share", first), first)
    share = first + np.maximum(times - seen - SETTLE, 0.0) * SPEED / np.maximum(beyond, 0.1)
    limit = np.where(wanted > angle, angle + np.minimum(share, last) * beyond, wanted)
    asked = np.where(times < seen, wanted, np.maximum(limit, wanted - BACK * (times - seen)))
    reference = Reference(np.stack([times, asked]), kinked=False)
    return replace(sampled, experiment=replace(known, reference=reference))
