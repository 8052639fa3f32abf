"""Commands that are limited from the touch on, as a grip policy limits them.

When a hand touches its object is known from the grasp alone. So such a grasp is simulated twice:
closed by the whole command, and then by one of which a share counts from the touch on. After a
while that share rises slowly, and the hand presses on. Set points are held for a while, as a link
sends them.
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
FREE, CREEP = 8.6, 0.25  # rad to which the command passes without a touch; rad/s beyond
STEP, LATE = 5e-3, 1e-3  # s between two set points; from the command to its set point


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
    now = np.maximum(times - LATE, 0.0)
    wanted = np.interp(now, *known.reference.knots)
    angle = float(free["position"][touched[0]])
    beyond = np.maximum(wanted - angle, 0.0)
    first = values["command.touch_share"]
    last = max(values.get("command.press_share", first), first)
    share = first + np.maximum(now - seen - SETTLE, 0.0) * SPEED / np.maximum(beyond, 0.1)
    limit = np.where(wanted > angle, angle + np.minimum(share, last) * beyond, wanted)
    passed = np.minimum(wanted, _passing(now, wanted))
    back = passed - BACK * np.maximum(now - seen, 0.0)
    asked = np.where(now < seen, passed, np.maximum(limit, back))
    return replace(sampled, experiment=replace(known, reference=_held(times, asked)))


def _passing(times: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """How far the command passes where nothing was touched [rad]."""
    beyond = np.flatnonzero(wanted > FREE)
    first = times[beyond[0]] if beyond.size else np.inf
    return FREE + CREEP * np.maximum(times - first, 0.0)


def _held(times: np.ndarray, asked: np.ndarray) -> Reference:
    """Set points [rad], each held until the next."""
    ends = times[1:] - 0.5 * LATE
    knots = np.concatenate([[0.0], np.repeat(ends, 2), [times[-1] + STEP]])
    return Reference(np.stack([knots, np.repeat(asked, 2)]), kinked=False)
