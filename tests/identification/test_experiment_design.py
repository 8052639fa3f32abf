"""The run worth recording next, and the channels worth logging in it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.truth.campaign import make
from benchmarks.truth.protocol import POOR, PROTOCOLS, Protocol, closures
from hannes.campaigns.campaign import Entry
from hannes.campaigns.segments import Segment, noise_floors
from hannes.core.recording.recording import Recording
from hannes.identification.diagnosis import experiment_design
from hannes.identification.diagnosis.baseline import COARSE
from hannes.identification.diagnosis.experiment_design import (
    Separation,
    explanations,
    proposed,
    separation,
)
from hannes.identification.diagnosis.linearisation import first
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.trials import Joint, SearchResult, Trial
from hannes.plants.hand.candidate_runs import proposals
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.catalogue import effects

NAMES = ["current_offset", "direction_friction"]
SIZES = {"current_offset.offset": 0.01, "direction_friction.dry": 0.05}


def logged(duties):
    """Closures of one hand, those with a duty where `duties` says so."""
    found = []
    for name, run in make(closures(len(duties)), 5).recordings.items():
        away = {"supply"} if duties[len(found)] else {"supply", "duty"}
        kept = {each: run[each] for each in run.channels if each not in away}
        units = {each: run.units[each] for each in kept}
        found.append(Entry(name, replace(run, channels=kept, units=units), "void", "fit"))
    return found


def test_more_channels_are_asked_for_only_where_no_run_separates_without():
    separations = {
        "slow": Separation(5.5, 60.0, ("duty",)),
        "soft": Separation(2.0, 90.0, ("duty",)),
    }
    assert proposed(separations, NAMES)["experiment"] == "slow"
    assert proposed(separations, NAMES)["also_log"] == []
    separations["slow"] = replace(separations["slow"], usual=4.5)
    found = proposed(separations, NAMES)
    assert found["experiment"] == "soft" and found["also_log"] == ["duty"]
    assert found["why"].endswith("by 90.0 standard deviations, without duty by 2.0")


def test_nothing_is_proposed_that_separates_too_little():
    assert proposed({"slow": Separation(1.0, 1.9, ("duty",))}, NAMES) is None
    assert proposed({}, NAMES) is None


def test_a_run_that_is_logged_as_all_others_asks_for_no_more():
    separations = {"slow": Separation(3.0, 3.0)}
    found = proposed(separations, NAMES)
    assert found["also_log"] == [] and "without" not in found["why"]


def test_channels_that_add_little_are_not_asked_for():
    found = proposed({"slow": Separation(3.0, 3.5, ("duty",))}, NAMES)
    assert found["also_log"] == [] and "without" not in found["why"]


def test_several_effects_that_explain_together_are_one_explanation():
    joint, other = Trial(("slack", "sag"), None, 90.0), Trial(("slack", "lag"), None, 85.0)
    part, single = Trial(("slack",), None, 60.0), Trial(("drag",), None, 50.0)
    found = SearchResult(None, None, [], [part, single], Joint(joint, others=(other,)), None, 1.0)
    assert explanations(found) == [joint, other, single]
    assert explanations(replace(found, joint=None)) == [part, single]


@pytest.fixture(scope="module")
def open_case():
    """Closures, two explanations of something in them, and a run that may be recorded next."""
    plant, entries = HandPlant(), logged([False, False])
    groups, both = grouped(plant, entries), [effects()[name] for name in NAMES]
    space = ParameterSpace(plant, groups, Settings(), both)
    baseline = first(Model(plant, groups, space, both), COARSE, 0)
    trials = []
    for name, size in SIZES.items():
        x, place = baseline.x.copy(), space.place(name)
        x[place] = size / space.parameters[place].scale
        trials.append(Trial((name.partition(".")[0],), replace(baseline, x=x), 20.0))
    found = SearchResult(baseline, baseline, [], trials, None, None, 1.0)
    run = make("poor", 5).recordings["01_void"]
    channels = {name: np.zeros(run.time.size) for name in ("position", "current")}
    channels |= {"time": run.time, "reference": run["reference"]}
    return found, [each.recording for each in entries], replace(run, channels=channels)


@pytest.mark.slow
def test_an_offset_of_the_current_is_separated_from_friction_by_the_duty(open_case):
    """The loop hides it in current and position, as in cases of the naming study."""
    found, recorded, run = open_case
    separations = separation(
        found, HandPlant(), Entry("poor", run, "poor"), recorded, *found.trials
    )
    assert separations.more == ("duty",)
    assert separations.most > 5.0 and separations.most > 2.0 * separations.usual
    more = {"duty": np.zeros(run.time.size)}
    with_duty = Entry("poor", run.with_channels(more, {"duty": "1"}), "poor")
    usual = separation(found, HandPlant(), with_duty, recorded, *found.trials)
    assert usual.more == () and usual.usual == pytest.approx(separations.most, rel=1e-6)
    loud = separation(
        replace(found, variance_factor=4.0), HandPlant(), with_duty, recorded, *found.trials
    )
    assert loud.most == pytest.approx(0.5 * separations.most, rel=1e-6)


@pytest.mark.slow
def test_a_run_that_cannot_be_simulated_separates_nothing(open_case, monkeypatch):
    """It once ended the whole diagnosis."""
    found, recorded, run = open_case

    def broken(self, group, rows, more, exact=False, further=None):
        return [None] * len(rows)

    monkeypatch.setattr(Model, "simulated", broken)
    entry = Entry("poor", run, "poor")
    assert separation(found, HandPlant(), entry, recorded, *found.trials) == Separation(0.0, 0.0)


def test_the_ball_has_no_channels_that_the_dynamometer_measures():
    runs = make(Protocol(PROTOCOLS["poor"].conditions[1:], POOR), 5).recordings
    (run,) = list(runs.values())[:1]
    assert "force" in run
    found = proposals({"dynamometer": run}, {"dynamometer": "a"})
    assert set(found["soft ball"].names) == {"reference", "position", "current"}
    assert "force" in found["dynamometer, half speed"]


def test_a_channel_that_one_recording_has_alone_has_a_floor():
    """It once had none: such a campaign was refused."""
    pieces = [Segment(each, "fit", np.ones(each.recording.time.size, bool))
              for each in logged([False, False, True])]  # fmt: skip
    found, how = noise_floors(HandPlant(), pieces)
    assert found["duty"] > 0.0 and "roughness" in how


def test_the_next_run_comes_after_all_others(monkeypatch):
    """A supply that falls by runs has fallen by then."""
    asked = []
    monkeypatch.setattr(
        experiment_design, "separation", lambda found, plant, run, *_: asked.append(run.number)
    )
    monkeypatch.setattr(experiment_design, "proposed", lambda *_: None)
    plant = SimpleNamespace(proposals=lambda recorded: dict.fromkeys(("slow", "soft")))
    pair = [SimpleNamespace(effects=())] * 2
    monkeypatch.setattr(experiment_design, "explanations", lambda _: pair)
    units = {"time": "s", "position": "rad"}
    still = Recording({name: np.arange(3.0) for name in units}, units)
    earlier = {"charge": 0.0, "time": 2.0}
    runs = [Entry(f"{k}", still, "void", number=k, earlier=earlier) for k in (0, 3, 7)]
    assert experiment_design.next_run(plant, None, runs, {}) is None
    assert asked == [8, 8]
