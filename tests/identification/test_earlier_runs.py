"""What earlier runs did, in the numbers of a run, and in a law that grows with it."""

from dataclasses import replace
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest
from sled import Sled, campaign, effect

from hannes.campaigns.campaign import Entry, following, in_order
from hannes.commands.diagnose import diagnose
from hannes.core.description import Description
from hannes.core.effect import Effect, Term
from hannes.core.errors import BadInput
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import EARLIER, Parameter
from hannes.core.recording.recording import Recording
from hannes.identification.diagnosis.shape.likeliest import _history_known
from hannes.simulation.catalogue import descriptions

GROWTH = 0.2  # N s/m, of the drag from each run to the next


@kernel
def over_time(time, per_time):
    """Drag gained [N s/m] over the time of earlier runs [s]."""
    return per_time * time


@kernel
def gummed(speed, per_time, earlier_time):
    """Drag that grows from run to run [N]."""
    return -over_time(earlier_time, per_time) * speed


GUMMED = Description(
    Effect(
        "generic_gumming", "Drag grows from run to run.", "F -= c T v", "none (2026)",
        (
            Parameter("per_time", 0.0, "N/m", (0.0, 5.0), "of earlier runs", off=0.0),
            Parameter("earlier_time", 0.0, "s", (0.0, 1e6), "of earlier runs", earlier="time"),
        ),
        (Term(gummed, ("force",)),),
    ),
    "the time of earlier runs", "s", (0.0, 8.0), "a drag", "N s/m", over_time,
)  # fmt: skip


class Gumming(Sled):
    """A sled that knows what grows from run to run."""

    generic: ClassVar = {"generic_gumming": GUMMED}


@kernel
def drag(size, speed):
    """Against the rail [N]."""
    return -size * speed


@pytest.fixture(scope="module")
def unknown():
    hidden = ((effect("more_drag", drag, 1e3, "N s/m"), 1e-6),)
    made = campaign(1, hidden, growth=GROWTH / 1e-6)
    plant = Gumming()
    return diagnose(replace(made, plant=plant, shipped=plant), progress=False, describe=True)


def a_run(seconds, current):
    time = np.linspace(0.0, seconds, 101)
    return Recording({"time": time, "current": current + 0.0 * time}, {"time": "s", "current": "A"})


def test_each_run_knows_what_those_of_its_unit_before_it_did():
    runs = [("a", a_run(2.0, -1.5)), ("b", a_run(5.0, 1.0)), ("a", a_run(1.0, 0.5))]
    made = in_order([Entry(f"{k}", run, "c", unit=unit) for k, (unit, run) in enumerate(runs)])
    assert [each.number for each in made] == [0, 1, 2]
    assert made[0].earlier == made[1].earlier == {"charge": 0.0, "time": 0.0}
    assert made[2].earlier == pytest.approx({"charge": 3.0, "time": 2.0})


def test_charge_is_not_known_after_a_run_without_a_current():
    time = np.linspace(0.0, 1.0, 11)
    bare = Recording({"time": time, "position": time}, {"time": "s", "position": "rad"})
    made = in_order([Entry("a", bare, "c"), Entry("b", a_run(1.0, 1.0), "c")])
    assert made[0].earlier["charge"] == 0.0 and made[1].earlier == {"time": 1.0}
    groups = [SimpleNamespace(earlier={n: np.array([each.earlier.get(n, np.nan)]) for n in EARLIER})
              for each in made]  # fmt: skip
    lengthening = descriptions()["generic_lengthening"]
    assert _history_known(lengthening, groups[:1]) and not _history_known(lengthening, groups)
    assert _history_known(descriptions()["generic_easing"], groups)


def test_what_follows_all_runs_knows_what_they_did():
    runs = in_order([Entry(f"{k}", a_run(2.0, 1.5), "c") for k in range(3)])
    new = following(runs, Entry("next", a_run(1.0, 0.5), "c"))
    assert new.number == 3 and new.earlier == pytest.approx({"charge": 9.0, "time": 6.0})


def test_only_what_earlier_runs_are_known_to_do_sets_a_parameter():
    with pytest.raises(BadInput, match=r'earlier = "heat": expected one of charge, time'):
        Parameter("warmth", 0.0, "J", (0.0, 1.0), "of earlier runs", earlier="heat")


def test_a_law_that_grows_from_run_to_run_is_found_and_follows(unknown):
    assert unknown.verdict.verdict == "unknown"
    shape = unknown.verdict.shape
    assert shape["name"] == "generic_gumming" and shape["closes"] > 0.8
    size = shape["parameters"]["generic_gumming.per_time"]
    assert size["value"] == pytest.approx(GROWTH / 0.998, rel=0.05)
    assert list(shape["parameters"]) == ["generic_gumming.per_time"]  # earlier runs set the other


def test_an_effect_that_grows_from_run_to_run_is_named_and_stands_after_all_runs():
    known = replace(GUMMED.effect, name="gumming")
    hidden = ((effect("more_drag", drag, 1e3, "N s/m"), 1e-6),)
    made = campaign(1, hidden, {known.name: known}, growth=GROWTH / 1e-6)
    named = diagnose(made, progress=False)
    assert named.verdict.effects == ["gumming"]
    assert named.plant.parameters["gumming.earlier_time"] == pytest.approx(8 * 0.998)


def test_the_described_machine_is_that_after_all_runs(unknown):
    last = unknown.campaign.entries[-1]
    after = last.earlier["time"] + float(np.ptp(last.recording.time))
    assert unknown.plant.parameters["generic_gumming.earlier_time"] == pytest.approx(after)
