"""A sound campaign is not refused because a channel of it answers to no parameter."""

from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

from hannes.campaigns.campaign import Entry
from hannes.campaigns.segments import Segment, noise_floors
from hannes.core.errors import BadInput
from hannes.core.parameter import Parameter
from hannes.core.recording.recording import Recording
from hannes.identification.diagnosis import baseline
from hannes.identification.holdout.least_squares import WeightedResidual
from hannes.identification.holdout.starting_points import start
from hannes.plants.plain import PlainPlant

TIMES = np.arange(0.0, 2.0, 0.01)
UNITS = {"time": "s", "drive": "1", "position": "m", "force": "N"}


class Probe(PlainPlant):
    """A probe that moves, and presses where it touches; its load cell counts in whole steps."""

    name = "probe"
    channels = UNITS
    required = ("drive",)
    judged = ("position", "force")
    base = (
        Parameter("probe.gain", 1.0, "m", (0.1, 10.0), "of its drive"),
        Parameter("probe.contact", 0.7, "m", (0.0, 10.0), "where it touches"),
        Parameter("probe.stiffness", 10.0, "N/m", (0.1, 1e4), "of what it touches"),
    )
    free: ClassVar = {"probe.gain": 0.03, "probe.stiffness": 0.3}
    block = 0.2
    step = 0.0  # N, of the load cell

    def simulate(self, parameters, recording):
        p = self.parameters.with_values(parameters)
        position = p["probe.gain"] * recording["drive"]
        force = p["probe.stiffness"] * np.maximum(position - p["probe.contact"], 0.0)
        return {"position": position, "force": np.round(force / self.step) * self.step
                if self.step else force}  # fmt: skip


class Coarse(Probe):
    """The same with a load cell of 4 N a step."""

    step = 4.0


class Blind(Probe):
    """The same, of which the force alone is compared."""

    judged = ("force",)
    free: ClassVar = {"probe.stiffness": 0.3}


def residual(plant, values, more=lambda rng: 0.0, runs=4):
    """Of recordings by a probe with these values, and more in their force."""
    segments = []
    for k in range(runs):
        rng = np.random.default_rng(k)
        given = {"time": TIMES, "drive": np.sin(3.0 * TIMES)}
        made = plant.simulate(values, given)
        made["position"] = made["position"] + 1e-3 * rng.standard_normal(TIMES.size)
        made["force"] = made["force"] + more(rng)
        recording = Recording({**given, **made}, UNITS)
        segments.append(Segment(Entry(str(k), recording, "x", "fit"), "fit", TIMES >= 0.0))
    return WeightedResidual(plant, segments, noise_floors(plant, segments)[0])


def noise(rng):
    return 0.05 * rng.standard_normal(TIMES.size)


def drift(rng):
    return 0.3 + 0.05 * np.cumsum(rng.standard_normal(TIMES.size)) / np.sqrt(TIMES.size)


@pytest.mark.parametrize("more", [noise, drift])
def test_a_force_that_is_noise_alone_starts_as_given(more):
    free = Probe().with_values({"probe.contact": 5.0})
    assert start(residual(free, {}, more), free, lambda text: None) == {}


def test_a_sensor_too_coarse_for_a_step_starts_as_given():
    plant = Coarse()
    assert start(residual(plant, {"probe.stiffness": 10.4}), plant, lambda text: None) == {}


def test_a_force_that_nothing_simulated_explains_is_left_to_the_effects():
    free = Probe().with_values({"probe.contact": 5.0})
    seen = residual(free, {}, lambda rng: 3.0 * np.maximum(np.sin(3.0 * TIMES) - 0.7, 0.0))
    assert start(seen, free, lambda text: None) == {}


def test_a_machine_of_which_nothing_answers_is_refused():
    plant = Blind().with_values({"probe.contact": 5.0})
    seen = residual(plant, {"probe.contact": 0.5})
    with pytest.raises(BadInput, match="the simulated force does not answer"):
        start(seen, plant, lambda text: None)


def group(name, rows, samples=None):
    """Repeats of one command whose force has these bins."""
    rows = np.array(rows)
    samples = rows[0] if samples is None else samples
    return SimpleNamespace(
        names=("force",), of=lambda name: slice(0, rows.shape[1]), measured=rows,
        mean=rows.mean(axis=0), count=len(rows), entries=[SimpleNamespace(name=name)],
        views=[SimpleNamespace(samples=lambda name: samples)],
    )  # fmt: skip


def refused(*groups):
    """Whether the force of the last group is refused where it is simulated as zero."""
    bins = [each.mean.size for each in groups]
    nominal = SimpleNamespace(
        model=SimpleNamespace(groups=list(groups)),
        vectors=[*(np.ones(n) for n in bins[:-1]), np.zeros(bins[-1])],
        derivatives=[*(np.ones((2, n)) for n in bins[:-1]), np.zeros((2, bins[-1]))],
    )
    try:
        baseline._require_answers(nominal)
    except BadInput:
        return True
    return False


PRESS = 50.0 * np.sin(np.linspace(0.0, 3.0, 60))


@pytest.fixture(autouse=True)
def smooth(monkeypatch):
    monkeypatch.setattr(baseline, "recorded_roughness", lambda group: {"force": 0.001})


def test_a_press_that_is_simulated_as_zero_is_refused():
    assert refused(group("a", [PRESS, 1.01 * PRESS]))


def test_a_load_cell_that_drifts_is_not_refused():
    walk = [0.05 * np.cumsum(np.random.default_rng(k).standard_normal(60)) for k in range(4)]
    assert not refused(group("a", walk))


def test_a_load_cell_that_toggles_by_a_step_is_not_refused():
    toggles = 2.0 * (np.random.default_rng(1).uniform(size=600) > 0.9)
    assert not refused(group("a", [toggles.reshape(60, 10).mean(axis=1)], toggles))


def test_little_beside_what_a_grasp_shows_is_not_refused():
    """A load cell moved through the air shows what it weighs."""
    free = 0.02 * PRESS
    assert not refused(group("grasp", [PRESS, PRESS]), group("free", [free, free]))
