"""Users who state nothing: what firmware does is read from the recordings."""

from dataclasses import replace

import numpy as np
import pytest

from hannes.campaigns.campaign import Campaign, Entry
from hannes.core.recording.recording import Recording
from hannes.plants.hand.plant import HandPlant


def closures(controller, runs=4):
    """A user who states nothing: short closures by a hand, its experiments say "continuous"."""
    text = SHORT.replace("continuous", controller)
    stated, entries = HandPlant(), []
    time = np.arange(0.0, 0.401, 1e-3)
    units = {"time": "s", "reference": "rad", "position": "rad", "current": "A"}
    blank = {"time": time, "reference": np.interp(time, [0.0, 0.25, 0.4], [0.0, 3.9, 1.4])}
    for k in range(runs):
        rng = np.random.default_rng(k)
        start = {**blank, "position": 0.0 * time, "current": 0.0 * time}
        bare = Recording(start, units, experiment=text)
        made = stated.with_values({"motor.dry_friction": 4.75e-3}).simulate({}, bare)
        noisy = made["current"] + 0.01 * rng.standard_normal(time.size)
        channels = {**blank, "position": made["position"], "current": noisy}
        recording = Recording(channels, units, experiment=SHORT)
        entries.append(Entry(f"{k}.csv", recording, "void", ("fit", "fit", "select", "show")[k]))
    return Campaign(stated, stated, tuple(entries), None, {})


SHORT = """
title = "short"
duration = "0.4 s"
sampling = "1 kHz"
controller = "continuous"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.25 s", "3.9 rad"], ["0.4 s", "1.4 rad"]]
"""


@pytest.mark.parametrize(("controller", "taken"), [("sampled", True), ("continuous", False)])
def test_a_sampled_controller_is_read_from_the_recordings(controller, taken):
    from hannes.identification.diagnosis.observed_controller import as_recorded
    from hannes.identification.diagnosis.settings import Settings

    campaign = closures(controller)
    found, said = as_recorded(campaign, Settings(0.03, 0.01, 0.01), 0, lambda text: None)
    assert bool(said) == taken
    assert all('"sampled"' in e.recording.experiment for e in found.entries) == taken
    bare = tuple(
        replace(e, recording=replace(e.recording, experiment="")) for e in campaign.entries
    )
    alone = replace(campaign, entries=bare)
    same, why = as_recorded(alone, Settings(0.03, 0.01, 0.01), 0, lambda text: None)
    assert ("no experiment says" in why) == taken
    assert all('"sampled"' in e.recording.experiment for e in same.entries) == taken
    if taken:
        assert "one sampled every 1 ms" in said
        again, nothing = as_recorded(found, Settings(), 0, lambda text: None)
        assert again is found and nothing == ""
