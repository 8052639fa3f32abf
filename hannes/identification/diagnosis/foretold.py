"""What a diagnosis may take at most, said before its first simulation."""

import time
from collections.abc import Sequence

import numpy as np

from hannes.campaigns.campaign import Campaign
from hannes.identification.diagnosis.work_bound import Work, ordinary_time
from hannes.plants.protocol import Plant

SLOW = 0.01  # s of one simulation, from which the time of all is said
MINUTE = 60.0


def foretold(campaign: Campaign, work: Work, uncertain: int) -> str:
    """`at most as much as 7,205 single simulations`, and how long that is where each is slow.

    uncertain: number of parameters of the machine
    """
    durations = command_durations(campaign)
    count = work.most(durations, uncertain) / float(np.mean(durations))
    text = f"at most as much as {count:,.0f} single simulations"
    each = _seconds_each(campaign)
    if each < SLOW:
        return text
    return f"{text}: each takes {1e3 * each:.2g} ms here, all up to {_long(each * count)}"


def command_durations(campaign: Campaign) -> list[float]:
    """What a run of each command that is simulated counts [s]."""
    plant, found = campaign.plant, {}
    for each in campaign.entries:
        lasts = float(np.ptp(each.recording.time))
        found[plant.same_run(each.recording)] = ordinary_time(plant, lasts)
    return list(found.values())


def _seconds_each(campaign: Campaign) -> float:
    """Processor time of one simulation of a plant that makes them one by one; 0 of others."""
    plant: Plant = campaign.plant
    if hasattr(plant, "many"):
        return 0.0
    took: Sequence[float] = [_timed(plant, campaign) for _ in range(2)]  # the first may compile
    return min(took)


def _timed(plant: Plant, campaign: Campaign) -> float:
    begun = time.process_time()
    with np.errstate(all="ignore"):
        plant.simulate(plant.parameters, campaign.entries[0].recording)
    return time.process_time() - begun


def _long(seconds: float) -> str:
    return f"{seconds / MINUTE:.0f} min" if seconds > MINUTE else f"{seconds:.0f} s"
