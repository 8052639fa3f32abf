"""What a diagnosis may take at most, said before its first simulation."""

import time

import numpy as np

from hannes.campaigns.campaign import Campaign
from hannes.core.errors import HannesError
from hannes.identification.diagnosis.work_bound import Work, ordinary_time

SLOW = 0.01  # s of one simulation, from which the time of all is said
ONCE = 20.0  # s, from which it is not made twice
MINUTE = 60.0


def foretold(campaign: Campaign, work: Work, uncertain: int) -> str:
    """`at most as much as 7,205 single simulations`, and how long that is where each is slow.

    uncertain: number of parameters of the machine
    """
    durations = command_durations(campaign)
    most = work.most(durations, uncertain)
    text = f"at most as much as {most / float(np.mean(durations)):,.0f} single simulations"
    each = _seconds_each(campaign)
    if each < SLOW:
        return text
    first = ordinary_time(campaign.plant, float(np.ptp(campaign.entries[0].recording.time)))
    return f"{text}: one takes {_long(each)} here, all up to {_long(each * most / first)}"


def command_durations(campaign: Campaign) -> list[float]:
    """What a run of each command that is simulated counts [s]."""
    plant, found = campaign.plant, {}
    for each in campaign.entries:
        lasts = float(np.ptp(each.recording.time))
        found[plant.same_run(each.recording)] = ordinary_time(plant, lasts)
    return list(found.values())


def _seconds_each(campaign: Campaign) -> float:
    """Processor time of the first run of a plant that makes them one by one; 0 of others."""
    if hasattr(campaign.plant, "many"):
        return 0.0
    took = _timed(campaign)
    return min(took, _timed(campaign)) if SLOW < took < ONCE else took  # the first may compile


def _timed(campaign: Campaign) -> float:
    """Processor time of one simulation; 0 where it fails, which the diagnosis says later."""
    begun, plant = time.process_time(), campaign.plant
    try:
        with np.errstate(all="ignore"):
            plant.simulate(plant.parameters, campaign.entries[0].recording)
    except HannesError:
        return 0.0
    return time.process_time() - begun


def _long(seconds: float) -> str:
    """`60 ms`, `1.2 s`, `12 s`, `3 min`."""
    if seconds < 1.0:
        return f"{1e3 * seconds:.0f} ms"
    return f"{seconds / MINUTE:.0f} min" if seconds > MINUTE else f"{seconds:.2g} s"
