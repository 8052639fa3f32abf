"""Whether recordings show a sampled controller where their experiments say a continuous one.

Who names a shipped experiment takes its continuous controller along, and hardly any real hand has
one. Firmware's ticks and rounding shift currents by more than noise; read as parameters, they make
a sound hand look wrong. So both are simulated as the machine runs, as given and refitted coarsely,
and the controller that is nearer to the means of repeats is taken. Where something large is
missing neither is near; whole encoder counts then speak for firmware, as nothing else reads them. A
machine can follow ticks that are not simulated, by values far from those given: with whole counts
that speaks for them too.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.segments import in_roles, noise_floors, split_campaign
from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.baseline import COARSE
from hannes.identification.diagnosis.gauss_newton import fitted
from hannes.identification.diagnosis.linearisation import first
from hannes.identification.diagnosis.multistart import Progress
from hannes.identification.diagnosis.noise_colour import noise_bandwidth
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.repeat_groups import Group, grouped
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.tuning import NOISE
from hannes.identification.diagnosis.work_bound import SearchEnded, Work
from hannes.plants.protocol import Plant

UNTESTED = (
    "experiments say a continuous controller; whether the recordings show a sampled one was not "
    "tested, as that takes more simulations than one diagnosis may make"
)


@dataclass(frozen=True)
class Controller:
    """A plant and its recordings under one controller; period [s], 0 for the one as stated."""

    plant: Plant
    entries: tuple[Entry, ...]
    period: float = 0.0


@dataclass(frozen=True)
class Apart:
    """How far a controller leaves the simulation from the recordings.

    distance: RMS in noise floors;  deviance: that and the machine's distance from its prior
    """

    distance: float = float("inf")
    deviance: float = float("inf")


def as_recorded(
    campaign: Campaign,
    settings: Settings,
    seed: int,
    progress: Progress,
    work: Work | None = None,
) -> tuple[Campaign, str]:
    """The campaign under the controller that its recordings show, and what was changed or ""."""
    others = list(_sampled(campaign))
    if not others:
        return campaign, ""
    progress("the controller")
    known = in_roles(split_campaign(campaign)[0], "fit", "select")
    levels, _ = noise_floors(campaign.plant, known)
    stated = Controller(campaign.plant, campaign.entries)
    work = work or Work()
    try:
        apart = [_apart(each, levels, settings, seed, work) for each in (stated, *others)]
    except SearchEnded:
        return campaign, UNTESTED
    stated_apart, counted = apart[0], _counted(campaign)
    pairs = list(zip(others, apart[1:], strict=True))
    near = _near(campaign)
    nearer = [each for each in pairs if _nearer(each[1], stated_apart, counted, near)]
    if not nearer:
        return campaign, ""
    taken, left = min(nearer, key=lambda each: each[1].distance)
    times = stated_apart.distance / left.distance
    planned = all(each.recording.experiment for each in campaign.entries)
    said = _said(taken.period, times, counted, planned)
    return replace(campaign, plant=taken.plant, entries=taken.entries), said


def _near(campaign: Campaign) -> float:
    """What a right controller leaves at most: means are of few repeats [noise floors]."""
    known = [each for each in campaign.entries if each.role in ("fit", "select")]
    count = len(known) / max(1, len(grouped(campaign.plant, known)))
    return NOISE.continuous_controller * float(np.sqrt(1.0 / count + NOISE.known_mean))


def _nearer(other: Apart, stated: Apart, counted: bool, near: float) -> bool:
    """Whether another controller is taken for the stated one.

    near: distance below which the stated one is as near as a right one
    """
    if not counted:
        return other.distance < NOISE.nearer_controller * stated.distance
    if other.distance < NOISE.counted_controller * stated.distance:
        return True
    if other.distance >= NOISE.farthest_controller * stated.distance:
        return False
    return other.deviance < stated.deviance or stated.distance > near


def _said(period: float, times: float, counted: bool, planned: bool = True) -> str:
    """What was taken and why; times: how much nearer it comes than the controller as stated."""
    text = "experiments say a continuous controller; "
    if not planned:
        text = "no experiment says what controller there was, so a continuous one was assumed; "
    sampled = f"one sampled every {1e3 * period:.3g} ms"
    if not np.isfinite(times):
        return f"{text}with it the machine cannot be simulated: {sampled} is taken"
    if times * NOISE.nearer_controller > 1.0:
        counts = "whole encoder counts and " if counted else ""
        nearer = f"which comes {times:.2g} times as near: that is taken"
        return f"{text}the recordings show {counts}{sampled}, {nearer}"
    nearer = f"It comes {times:.2g} times as near" if times > 1.05 else "It comes no nearer"
    return (
        f"{text}the recordings are whole encoder counts, which firmware reads, so {sampled} is "
        f"taken. {nearer}, which alone would not decide it"
    )


def _counted(campaign: Campaign) -> bool:
    """Whether every recording holds whole counts of an encoder, as firmware reads them."""
    counted = getattr(campaign.plant, "counted", None)
    return counted is not None and all(counted(each.recording) for each in campaign.entries)


def _sampled(campaign: Campaign) -> Iterator[Controller]:
    """The campaign under sampled controllers, where any of its experiments has a continuous one."""
    make, tick = (getattr(campaign.plant, name, None) for name in ("sampled", "tick"))
    if make is None or tick is None:
        return
    made = [make(each.recording) for each in campaign.entries]
    if not any(made):
        return
    entries = tuple(
        each if other is None else replace(each, recording=other)
        for each, other in zip(campaign.entries, made, strict=True)
    )
    for period in _periods(campaign.plant.parameters[tick], entries):
        yield Controller(campaign.plant.with_values({tick: period}), entries, period)


def _periods(usual: float, entries: Sequence[Entry]) -> list[float]:
    """Periods [s] to try: that of the machine, and how often it was logged."""
    logged = float(np.median([np.median(np.diff(each.recording.time)) for each in entries]))
    low, high = NOISE.logged_periods
    other = [logged] if abs(logged / usual - 1.0) > 0.01 and low <= logged <= high else []
    return [usual, *other]


def _apart(
    controller: Controller,
    levels: Mapping[str, float],
    settings: Settings,
    seed: int,
    work: Work,
) -> Apart:
    """RMS of simulated minus mean recorded in noise floors, geometric mean over channels.

    As given or refitted, whichever is nearer; infinite where it cannot be simulated.
    """
    known = [each for each in controller.entries if each.role in ("fit", "select")]
    groups = grouped(controller.plant, known)
    space = ParameterSpace(controller.plant, groups, settings, ())
    bandwidth = noise_bandwidth(controller.plant, groups)
    model = Model(controller.plant, groups, space, (), work, bandwidth)
    try:
        given = first(model, COARSE, seed)
        places = np.array([given.x, fitted(given, 5, restarts=1).x])
    except ComputationFailed:
        return Apart()
    made = [model.vectors(group, places, False, exact=True) for group in groups]
    distances = [_between(groups, [each[k] for each in made], levels) for k in range(len(places))]
    off = np.sum((space.prior * places) ** 2, axis=1)
    deviances = 2.0 * NOISE.independent_values * np.log(distances) + off
    return Apart(min(distances), float(np.min(deviances)))


def _between(
    groups: Sequence[Group], made: Sequence[np.ndarray], levels: Mapping[str, float]
) -> float:
    """The same of one simulation of each group, shape (n,)."""
    squares: dict[str, list[float]] = {}
    for group, vector in zip(groups, made, strict=True):
        apart = group.mean - vector
        for name in group.names:
            size = float(np.mean((apart[group.of(name)] / levels[name]) ** 2))
            squares.setdefault(name, []).append(size)
    means = [np.mean(each) + NOISE.known_mean for each in squares.values()]
    return float(np.exp(0.5 * np.mean(np.log(means))))
