"""Repeats of one run share one simulation, which starts where they start in the mean."""

import numpy as np
import pytest

from hannes.campaigns.campaign import Entry
from hannes.core.recording.recording import Recording
from hannes.identification.binned_run import BIN
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.tuning import FIT
from hannes.plants.plain import PlainPlant

UNITS = {"time": "s", "reference": "rad", "position": "rad"}
TIME = 0.01 * np.arange(50)


class Shaft(PlainPlant):
    """Its runs differ by where they were seen to start."""

    name = "shaft"
    channels = UNITS
    required = ("reference", "position")
    judged = ("position",)

    def same_run(self, recording):
        return recording["reference"].tobytes()


def entry(number, reference, position):
    channels = {"time": TIME, "reference": reference, "position": position}
    return Entry(f"{number}.csv", Recording(channels, UNITS), "steps", "fit", number=number)


def test_the_simulation_starts_at_the_mean_of_the_repeats():
    command = np.sin(TIME)
    seen = np.random.default_rng(0).standard_normal((3, TIME.size))
    (group,) = grouped(Shaft(), [entry(k, command, each) for k, each in enumerate(seen)])
    assert np.allclose(group.recording["position"], seen.mean(axis=0))
    assert np.array_equal(group.recording["reference"], command)
    assert np.array_equal(group.measured, seen)


def test_what_all_runs_share_is_that_of_the_first_to_the_bit():
    command = 0.1 * np.arange(TIME.size)
    runs = [entry(k, command, np.full(TIME.size, 0.3)) for k in range(3)]
    (group,) = grouped(Shaft(), runs)
    assert group.recording is runs[0].recording


@pytest.mark.parametrize("interval", [0.001, 0.002, 0.00125, 1.0 / 60.0, 0.02])
def test_every_bin_has_as_many_samples(interval):
    """Seven and six in turn: a mean of six is noisier, and simulated noise was not."""
    time = interval * np.arange(round(1.6 / interval) + 1)
    channels = {"time": time, "reference": np.sin(time), "position": np.cos(time)}
    made = Entry("1.csv", Recording(channels, UNITS), "steps", "fit")
    (group,) = grouped(Shaft(), [made])
    assert group.width >= max(BIN, 1.6 / FIT.bins) - 1e-6
    counts = np.bincount((time / group.width + 1e-9).astype(int))
    assert np.ptp(counts[:-1]) == 0 or interval > group.width
