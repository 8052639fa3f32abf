"""What earlier runs did, in the numbers of a run, and in a law that grows with it."""

from dataclasses import replace

import numpy as np
import pytest
from sled import Sled, campaign, effect

from hannes.campaigns.campaign import Entry, in_order
from hannes.commands.diagnose import diagnose
from hannes.core.description import Description
from hannes.core.effect import Effect, Term
from hannes.core.errors import BadInput
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter
from hannes.core.recording.recording import Recording

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

    generic = {"generic_gumming": GUMMED}  # noqa: RUF012 - read alone


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


def test_the_described_machine_is_that_after_all_runs(unknown):
    last = unknown.campaign.entries[-1]
    after = last.earlier["time"] + float(np.ptp(last.recording.time))
    assert unknown.plant.parameters["generic_gumming.earlier_time"] == pytest.approx(after)
