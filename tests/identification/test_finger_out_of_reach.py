"""A finger that touches nothing as given: another start, a refusal, and the work of a hold-out."""

from dataclasses import replace

import numpy as np
import pytest

from hannes.campaigns.campaign import Campaign, Entry
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.identification.holdout.diagnosis import diagnose_by_holdout
from hannes.plants.finger.plant import Finger


def finger(contact, nearest, role, seed, effect=None):
    """A finger that closes to an angle [counts] and touches at `contact` [100 counts]."""
    plant, rng, time = Finger(), np.random.default_rng(seed), np.arange(0.0, 12.0, 0.02)
    closing = np.clip(1.0 - np.abs(time % 6.0 - 3.0) / 3.0, 0.0, 1.0)
    angle = np.round(1000.0 - (1000.0 - nearest) * closing)
    units = {"time": "s", "angle": "1", "force": "1"}
    bare = Recording({"time": time, "angle": angle, "force": np.zeros(time.size)}, units)
    values = {"contact.angle": contact}
    if effect:
        plant = plant.with_effects(plant.catalogue[effect])
        values[f"{effect}.time"] = 0.15
    force = plant.simulate(values, bare)["force"] + 2.0 * rng.standard_normal(time.size)
    return Entry(f"{seed}.csv", Recording({**bare.channels, "force": force}, units), "", role)


def finger_campaign(contact, effect=None):
    """Nine closings, none of which goes below the angle that the finger is given."""
    roles = ("fit", "select", "show")
    entries = tuple(
        finger(contact, 790.0 + 20.0 * (k % 3), roles[k // 3], k, effect) for k in range(9)
    )
    return Campaign(Finger(), Finger(), entries, None, dict(Finger.catalogue), base="finger")


def test_a_finger_that_never_touches_as_given_is_started_elsewhere():
    from hannes.commands.diagnose import diagnose

    verdict = diagnose(finger_campaign(8.6, "force_lag"), progress=False).verdict
    assert "force_lag" in verdict.effects
    gap = verdict.gap["force"]
    assert gap["after"] < 2.0 * gap["floor"] < gap["before"] < gap["as_given"]


def test_a_finger_that_cannot_touch_is_refused_in_words():
    from hannes.commands.diagnose import diagnose

    campaign = finger_campaign(8.6)
    far = tuple(
        replace(each, recording=Recording(
            {**each.recording.channels, "angle": each.recording["angle"] + 2000.0},
            each.recording.units))
        for each in campaign.entries
    )  # fmt: skip
    with pytest.raises(BadInput, match=r"does not answer to contact\.stiffness, contact\.angle"):
        diagnose(replace(campaign, entries=far), progress=False)


def test_hold_out_keeps_the_number_that_it_said(monkeypatch):
    made, said, counts, simulate = finger_campaign(8.6, "force_lag"), [], [], Finger.simulate

    def counted(self, parameters, recording):
        counts.append(0)
        return simulate(self, parameters, recording)

    monkeypatch.setattr(Finger, "simulate", counted)
    diagnose_by_holdout(made, 0, said.append)
    assert len(counts) <= int(said[0].split()[2].replace(",", ""))
