"""Grip policy: how far the hand may close on what it holds, by what recognition says of it.

A pure, causal function of one tick: settings, memory and a sample give new memory and a set point.
Plain arithmetic on fixed numbers, so that it is the same in C (`hannes export-c`).

Until something is touched, the command passes as far as `approach_from`, more slowly to `free_to`,
and hardly beyond. Fingers strike an object before its touch is seen, and push it against the palm:
the faster, the harder. And a weak touch is seen late or never, so that the whole command would
squeeze most of all what shows least. From the touch on the command's further travel counts for a
share only: `soft_share` at first, and as long as the object is surely soft. While doubt remains the
hand goes on squeezing, slowly, up to `probe_share`: pressed on in time, an object shows its
stiffness. Once it did, that decides, and a soft one gets its first share again. All of the travel
counts once the object was recognised as rigid for `dwell`, or is stiff and not likely soft. Where
no stiffness is known, that probability decides alone, once `patience` is over. A late hold gets a
little more: what is pressed on from rest gets less of the force.
A force set point closes or opens within that limit instead.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class GripSettings:
    """What the policy goes by; times in s, angles in rad at the output shaft, force in N."""

    approach_from: float = 5.0  # rad to which the command passes where nothing is touched
    approach_speed: float = 9.0  # rad/s, most by which the set point goes on from there
    free_to: float = 8.6  # rad to which it does so
    free_speed: float = 0.25  # rad/s, by which the set point goes on from there
    soft_share: float = 0.5  # of the commanded travel beyond the touch, for a soft object
    probe_share: float = 0.75  # the same while doubt remains
    probe_speed: float = 2.0  # rad/s, by which the limit goes from one to the other
    settle: float = 0.15  # s from the touch until that may begin
    doubt_until: float = 0.2  # s from the touch until which it must begin to show the stiffness
    doubt_from: float = 0.065  # probability of rigid from which there is doubt
    rigid_from: float = 0.975  # probability of rigid from which it may be held firmly
    soft_below: float = 0.25  # probability of rigid below which a firm hold ends
    dwell: float = 0.03  # s for which that probability must last
    stiff_from: float = 1.0  # stiffness over the border from which an object is held firmly
    patience: float = 0.7  # s from the touch until doubt is decided without a stiffness
    decide_from: float = 0.4  # probability of rigid from which it is then held firmly
    averaging: float = 0.1  # s over which that probability is averaged
    late: float = 0.2  # more of the travel for each second from `settle` to a firm hold
    late_most: float = 0.06  # the most of that
    speed: float = 12.0  # rad/s, most by which the limit changes
    force_gain: float = 0.15  # rad/s for each newton that is missing to a force set point
    force_speed: float = 3.0  # rad/s, most of the same


class GripSample(NamedTuple):
    """What is known at one tick: SI, angles at the output shaft.

    rigid: probability, 0.5 where nothing is known; touched: whether something is held, and
    `touch_position` where it was touched; force: estimate with its upper end; force_wanted: set
    point [N], 0 or less for none; stiffness: of an object that was pressed on, over the border of
    soft and rigid, 0 where it is not known.
    """

    period: float  # s since the last tick
    wanted: float  # rad, the command
    position: float  # rad, measured
    touched: bool
    touch_position: float
    rigid: float
    force: float
    force_high: float
    force_wanted: float
    stiffness: float = 0.0


class GripMemory(NamedTuple):
    """What the policy keeps from tick to tick."""

    since: float = 0.0  # s from the touch on, 0 before
    certain: float = 0.0  # s for which rigid has been probable enough
    mean: float = 0.5  # fading mean of the probability of rigid
    share: float = 0.0  # of the travel beyond the touch that is given; 0 before the touch
    firm: bool = False  # held as a rigid object
    offset: float = 0.0  # rad from the touch to the set point, under force control
    set_point: float | None = None  # rad, of the last tick; None: where the hand is
    uncertain: bool = False  # pressed on in doubt in time, so that the stiffness counts


def grip(
    settings: GripSettings, memory: GripMemory, sample: GripSample
) -> tuple[GripMemory, float]:
    """Go on by one tick; returns the new memory, and the set point [rad] for the board."""
    last = sample.position if memory.set_point is None else memory.set_point
    if not sample.touched:
        set_point = min(sample.wanted, _free(settings, last, sample.period))
        return GripMemory(set_point=set_point), set_point
    since = memory.since + sample.period
    half = 0.5 * sample.period
    certain = memory.certain + sample.period if sample.rigid >= settings.rigid_from else 0.0
    mean = memory.mean + min(sample.period / settings.averaging, 1.0) * (sample.rigid - memory.mean)
    known = memory.uncertain and sample.stiffness > 0.0
    if known:
        firm = sample.stiffness >= settings.stiff_from and mean >= settings.soft_below
    else:
        firm = _firm(settings, memory.firm, mean, certain + half, since + half)
    doubt = since >= settings.settle and sample.rigid > settings.doubt_from
    in_time = doubt and since < settings.doubt_until
    uncertain = known or (not firm and (memory.uncertain or in_time))
    beyond = sample.wanted - sample.touch_position
    if beyond <= 0.0:  # the command is to open
        opened = GripMemory(since, certain, mean, 0.0, firm, 0.0, sample.wanted, uncertain)
        return opened, sample.wanted
    if firm:
        share = _firm_share(settings, memory, since)
    else:
        presses = not known and (doubt or (uncertain and since < settings.patience))
        share = _soft_share(settings, memory.share, sample.period, presses, beyond)
    offset = share * beyond
    if sample.force_wanted > 0.0:
        offset = _force_offset(settings, memory, sample, offset, firm)
    most = settings.speed * sample.period
    target = sample.touch_position + offset
    set_point = min(max(target, last - most), last + most)
    memory = GripMemory(since, certain, mean, share, firm, offset, set_point, uncertain)
    return memory, set_point


def _free(settings: GripSettings, last: float, period: float) -> float:
    """How far the command passes [rad] where nothing is touched; `last`: set point of before."""
    slowly = min(last + settings.approach_speed * period, settings.free_to)
    return max(settings.approach_from, slowly, last + settings.free_speed * period)


def _firm(settings: GripSettings, firm: bool, mean: float, certain: float, since: float) -> bool:
    """Whether the object is to be held firmly, by the mean probability of rigid.

    certain, since: of the memory, and half a tick, so that they count to the nearest one
    """
    if firm:
        return mean >= settings.soft_below
    if certain >= settings.dwell:
        return True
    return since >= settings.patience and mean > settings.decide_from


def _firm_share(settings: GripSettings, memory: GripMemory, since: float) -> float:
    """Share of the travel beyond the touch for a rigid object, as it was when it became one."""
    if memory.firm:
        return max(memory.share, 1.0)
    late = max(since - settings.settle, 0.0)
    return 1.0 + min(settings.late * late, settings.late_most)


def _soft_share(
    settings: GripSettings, share: float, period: float, presses: bool, beyond: float
) -> float:
    """Share of the travel beyond the touch that is given while the object is not surely rigid."""
    goal = settings.probe_share if presses else settings.soft_share
    step = settings.probe_speed * period / max(beyond, 0.1)
    start = min(max(share, settings.soft_share), settings.probe_share)
    return min(max(goal, start - step), start + step)


def _force_offset(
    settings: GripSettings, memory: GripMemory, sample: GripSample, most: float, firm: bool
) -> float:
    """Travel beyond the touch [rad] that brings the force to its set point, at most `most`.

    A soft object is held by the upper end of the force's band, so that doubt squeezes less.
    """
    force = sample.force if firm else sample.force_high
    rate = settings.force_gain * (sample.force_wanted - force)
    rate = min(max(rate, -settings.force_speed), settings.force_speed)
    start = memory.offset if memory.since > 0.0 else sample.position - sample.touch_position
    offset = start + rate * sample.period
    if math.isnan(offset):
        return 0.0
    return min(max(offset, 0.0), most)
