"""An accident of a sensor that most repeats show at the same time is the machine's own doing."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.quality.finding import fault
from hannes.campaigns.shared_findings import with_shared_as_warnings
from hannes.core.recording.recording import Recording
from hannes.plants.hand.plant import HandPlant

TIME = np.linspace(0.0, 2.0, 201)
RUN = Recording({"time": TIME, "position": TIME}, {"time": "s", "position": "rad"})
SLIP = fault("slip", "position", "turns less: the encoder slips", time=1.0, size=0.03)


def levels(*shown, conditions=None):
    """Levels of the findings of some runs, each with one finding or None."""
    conditions = conditions or ["closing"] * len(shown)
    entries = tuple(Entry(f"{k}.csv", RUN, each) for k, each in enumerate(conditions))
    plant = HandPlant()
    campaign = Campaign(plant, plant, entries, Path("out"), {}, "")
    found = [(f"{k}.csv", [each] if each else []) for k, each in enumerate(shown)]
    judged = with_shared_as_warnings(campaign, found)
    return [each.level for _, some in judged for each in some]


def at(time, size=0.03):
    return replace(SLIP, time=time, size=size)


def test_what_most_repeats_show_is_a_warning():
    assert levels(at(1.0), at(1.04), at(0.98)) == ["warning"] * 3
    assert levels(at(1.0), None, at(1.02)) == ["warning"] * 2


@pytest.mark.parametrize(
    "shown",
    [(SLIP,), (SLIP, None), (SLIP, None, None, SLIP), (SLIP, at(1.6))],
    ids=["alone", "one of two", "half", "elsewhere"],
)
def test_an_accident_stays_a_fault(shown):
    assert set(levels(*shown)) == {"fault"}


def test_runs_of_another_condition_are_no_repeats():
    assert levels(SLIP, SLIP, conditions=["closing", "grasp"]) == ["fault"] * 2


def test_what_one_command_shows_another_may_show_for_as_long():
    conditions = ["closing", "closing", "grasp", "grasp"]

    def stall(time, lasting):
        return replace(SLIP, kind="frozen", time=time, size=lasting)

    shown = stall(1.0, 0.12), stall(1.1, 0.06)
    brief, long = stall(0.3, 0.05), stall(0.3, 1.8)
    assert levels(*shown, brief, None, conditions=conditions) == ["warning"] * 3
    assert levels(*shown, long, None, conditions=conditions)[2] == "fault"
    assert levels(*shown, at(0.3), None, conditions=conditions)[2] == "fault"  # it slips there
    other = replace(brief, channel="force")
    assert levels(*shown, other, None, conditions=conditions)[2] == "fault"


def test_other_faults_that_repeats_share_stay_faults():
    sign = replace(SLIP, kind="sign")
    assert levels(sign, sign, sign) == ["fault"] * 3


def test_the_text_says_how_many():
    plant = HandPlant()
    entries = tuple(Entry(f"{k}.csv", RUN, "closing") for k in range(3))
    campaign = Campaign(plant, plant, entries, Path("out"), {}, "")
    found = [(each.name, [SLIP]) for each in entries]
    (_, (one,)), *_ = with_shared_as_warnings(campaign, found)
    assert one.text.endswith(
        "; 3 of 3 repeats of closing show it at the same time, so the machine may do that itself"
    )
