"""Commands that are limited from the touch on, as a grip policy limits them.

When a hand touches its object is known from the grasp alone. So such a grasp is simulated twice:
closed as a policy closes where nothing is touched, and then by a command of which a share counts
from the touch on. After a while that share rises slowly, and the hand presses on. Set points are
held for a while, as a link sends them.

The touch is the true one, known after a delay; or, as a policy has it, that which the sensors show,
once the window that shows it is over.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hannes.dataset.sampling import SampledGrasp, sensed
from hannes.dataset.touch_seen import seen_touch
from hannes.simulation.experiment.experiment import Reference
from hannes.simulation.trajectory import Grasp

TOUCH = 1.0  # N of force, from which it is touched
SETTLE, SPEED = 0.15, 2.0  # s until the share rises; rad/s at which the limit then does
TURN = 12.0  # rad/s at most by which the command goes to its limit from the touch on
NEAR, APPROACH = 5.0, 9.0  # rad to which the command passes without a touch; rad/s at most beyond
FREE, CREEP = 8.6, 0.25  # rad to which it does so; rad/s beyond
STEP, LATE = 5e-3, 1e-3  # s between two set points; from the command to its set point
HOP = 10e-3  # s between two windows of recognition
NEVER = (np.inf, 0.0)


def is_limited(sampled: SampledGrasp) -> bool:
    """Whether the grasp's command is limited from the touch on."""
    return sampled.values.get("command.touch_share", 1.0) < 1.0


def approaching(sampled: SampledGrasp) -> SampledGrasp:
    """The grasp with the command that a policy passes where nothing is touched."""
    times = _times(sampled)
    passed = _passing(times, np.interp(_known(times), *sampled.experiment.reference.knots))
    return replace(sampled, experiment=replace(sampled.experiment, reference=_held(times, passed)))


def limited(sampled: Sequence[SampledGrasp], free: Sequence[Grasp]) -> list[SampledGrasp]:
    """The grasps with their commands limited; `free`: they, simulated as `approaching`."""
    return [_limited(each, grasp) for each, grasp in zip(sampled, free, strict=True)]


def _limited(sampled: SampledGrasp, free: Grasp) -> SampledGrasp:
    values, known = sampled.values, sampled.experiment
    seen, angle = (_seen if values.get("command.touch_seen") else _true)(sampled, free)
    times = _times(sampled)
    now = _known(times)
    wanted = np.interp(now, *known.reference.knots)
    beyond = np.maximum(wanted - angle, 0.0)
    first = values["command.touch_share"]
    most = max(values.get("command.press_share", first), first)
    pressed = SPEED * np.clip(times - seen - SETTLE, 0.0, STEP)  # rad of each set point
    share = first + np.cumsum(pressed / np.maximum(beyond, 0.1))
    limit = np.where(wanted > angle, angle + np.minimum(share, most) * beyond, wanted)
    passed = _passing(times, wanted)
    last = min(seen, known.duration) - LATE  # tick of the last set point that no touch limits
    turned = TURN * np.maximum(now - last, 0.0)
    from_there = np.interp(last, now, passed)
    asked = np.clip(limit, from_there - turned, from_there + turned)
    reference = _held(times, np.where(now < seen, passed, asked))
    return replace(sampled, experiment=replace(known, reference=reference))


def _true(sampled: SampledGrasp, free: Grasp) -> tuple[float, float]:
    """When the true touch is known [s], never where nothing is touched, and where it was [rad]."""
    touched = np.flatnonzero(free["force"] > TOUCH)
    if not touched.size:
        return NEVER
    delay = sampled.values.get("command.touch_delay", 0.0)
    return float(free.time[touched[0]]) + delay, float(free["position"][touched[0]])


def _seen(sampled: SampledGrasp, free: Grasp) -> tuple[float, float]:
    """The same of the touch that the sensors show: at the end of the window with that sample."""
    current, position = (sensed(sampled, free, name) for name in ("current", "position"))
    step = float(free.time[1] - free.time[0])
    found = seen_touch(current, position, step)
    if found is None:
        return NEVER
    hop = max(1, round(HOP / step))
    end = -(-(found[0] + 1) // hop) * hop - 1
    return end * step, float(position[found[1]])


def _times(sampled: SampledGrasp) -> np.ndarray:
    """When set points arrive [s]."""
    return np.arange(0.0, sampled.experiment.duration + STEP, STEP)


def _known(times: np.ndarray) -> np.ndarray:
    """Of which moments the command is, that set points at `times` were made of [s]."""
    return np.maximum(times - LATE, 0.0)


def _passing(times: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """What passes of set points `wanted` at `times` where nothing was touched [rad]."""
    passed = np.zeros(times.size)
    for k in range(1, times.size):
        step, last = times[k] - times[k - 1], passed[k - 1]
        slowly = max(min(last + APPROACH * step, FREE), last + CREEP * step)
        passed[k] = min(wanted[k], max(NEAR, slowly))
    return passed


def _held(times: np.ndarray, asked: np.ndarray) -> Reference:
    """Set points [rad], each held until the next."""
    ends = times[1:] - 0.5 * LATE
    knots = np.concatenate([[0.0], np.repeat(ends, 2), [times[-1] + STEP]])
    return Reference(np.stack([knots, np.repeat(asked, 2)]), kinked=False)
