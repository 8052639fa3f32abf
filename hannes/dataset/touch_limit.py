"""Commands that are limited from the touch on, as a grip policy limits them.

When a hand touches its object is known from the grasp alone. So such a grasp is simulated twice:
closed by the whole command, and then by one of which a share counts from the touch on. After a
while that share rises slowly, and the hand presses on. Set points are held for a while, as a link
sends them.

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
BACK = 12.0  # rad/s at most by which the command goes back at the touch
FREE, CREEP = 8.6, 0.25  # rad to which the command passes without a touch; rad/s beyond
STEP, LATE = 5e-3, 1e-3  # s between two set points; from the command to its set point
HOP = 10e-3  # s between two windows of recognition
NEVER = (np.inf, 0.0)


def is_limited(sampled: SampledGrasp) -> bool:
    """Whether the grasp's command is limited from the touch on."""
    return sampled.values.get("command.touch_share", 1.0) < 1.0


def limited(sampled: Sequence[SampledGrasp], free: Sequence[Grasp]) -> list[SampledGrasp]:
    """The grasps with their commands limited; `free`: the same, simulated by the whole command."""
    return [_limited(each, grasp) for each, grasp in zip(sampled, free, strict=True)]


def _limited(sampled: SampledGrasp, free: Grasp) -> SampledGrasp:
    values, known = sampled.values, sampled.experiment
    seen, angle = (_seen if values.get("command.touch_seen") else _true)(sampled, free)
    times = np.arange(0.0, known.duration + STEP, STEP)
    now = np.maximum(times - LATE, 0.0)
    wanted = np.interp(now, *known.reference.knots)
    beyond = np.maximum(wanted - angle, 0.0)
    first = values["command.touch_share"]
    most = max(values.get("command.press_share", first), first)
    pressed = np.where(now >= seen + SETTLE, SPEED * STEP, 0.0)  # rad of each set point
    share = first + np.cumsum(pressed / np.maximum(beyond, 0.1))
    limit = np.where(wanted > angle, angle + np.minimum(share, most) * beyond, wanted)
    passed = np.minimum(wanted, _passing(now, wanted))
    last = min(seen, known.duration) - LATE  # tick of the last set point that no touch limits
    back = np.interp(last, now, passed) - BACK * np.maximum(now - last, 0.0)
    asked = np.where(now < seen, passed, np.maximum(limit, back))
    return replace(sampled, experiment=replace(known, reference=_held(times, asked)))


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
