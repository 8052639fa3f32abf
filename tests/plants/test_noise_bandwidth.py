"""Noise of the current sensor that a filter has coloured, in the firmware and in recordings."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.truth.bench import CURRENT
from benchmarks.truth.campaign import make
from benchmarks.truth.protocol import closures
from hannes.control.sensor_noise import coloured, gaussian
from hannes.identification.diagnosis.noise_colour import noise_bandwidth as asked_bandwidth
from hannes.identification.diagnosis.simulator import Model
from hannes.plants.hand.batch_runs import smoothness
from hannes.plants.hand.noise_bandwidth import BANDWIDTHS, noise_bandwidth
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.hand.hand import Hand

PERIOD = 1e-3  # s
LEVEL = "controller.current_noise"


def closed(count, bandwidth, seed=11):
    """Recordings of free closures by the independent truth, the same command each time."""
    return list(make(closures(count), seed, bandwidth=bandwidth).recordings.values())


def drawn(bandwidth, seed=5):
    return np.array([coloured(seed, tick, bandwidth, PERIOD) for tick in range(20_000)])


@pytest.mark.parametrize("bandwidth", [40.0, 200.0])
def test_noise_of_a_bandwidth_is_a_first_order_autoregression(bandwidth):
    keep = np.exp(-2.0 * np.pi * bandwidth * PERIOD)
    values = drawn(bandwidth)
    assert values.std() == pytest.approx(1.0, abs=0.05)
    for lag in (1, 3):
        found = np.mean(values[lag:] * values[:-lag])
        assert found == pytest.approx(keep**lag, abs=0.07)
    rough = np.std(np.diff(values, 2)) / np.sqrt(6.0)
    ticks = SimpleNamespace(time=np.arange(9) * PERIOD)
    assert rough == pytest.approx(smoothness(bandwidth, ticks), rel=0.03)


def test_noise_without_a_bandwidth_is_white_and_as_before():
    assert drawn(0.0)[:9].tolist() == [gaussian(5, tick) for tick in range(9)]
    assert smoothness(0.0, None) == 1.0


@pytest.mark.parametrize("bandwidth", [45.0, 110.0, 250.0])
def test_a_bandwidth_is_read_from_repeats(bandwidth):
    found = noise_bandwidth(Hand(), [closed(5, bandwidth)])
    near = np.abs(np.log(np.array(BANDWIDTHS[1:]) / bandwidth))
    assert abs(np.log(found / bandwidth)) < near.min() + 0.45  # a step of those tried


def test_white_noise_has_none_nor_have_runs_without_repeats():
    assert noise_bandwidth(Hand(), [closed(5, None)]) == 0.0
    assert noise_bandwidth(Hand(), [[each] for each in closed(3, 45.0)]) is None
    assert noise_bandwidth(Hand(), []) is None


def test_what_repeats_differ_by_beside_noise_is_no_colour():
    """A ripple whose phase is another in each run."""
    runs = []
    for number, each in enumerate(closed(5, None)):
        time, current = each.time, each["current"]
        ripple = 6.0 * CURRENT * np.sin(2.0 * np.pi * 60.0 * time + number)
        runs.append(replace(each, channels={**each.channels, "current": current + ripple}))
    assert noise_bandwidth(Hand(), [runs]) == 0.0


def test_coloured_noise_is_as_loud_as_that_of_the_recording():
    (recording,) = closed(1, 60.0)
    plant = HandPlant()
    columns = plant.noisy(recording, 3, 60.0)
    assert columns[LEVEL] == pytest.approx(np.full(3, CURRENT), rel=0.15)
    assert columns["controller.noise_bandwidth"].tolist() == [60.0] * 3
    white = plant.noisy(recording, 3)
    assert white[LEVEL].max() < 0.8 * CURRENT  # samples are less rough
    assert not white["controller.noise_bandwidth"].any()
    stated = HandPlant(Hand().with_values({"controller.noise_bandwidth": 60.0}))
    for name, column in stated.noisy(recording, 3).items():  # the file's, where none is asked for
        assert column.tolist() == columns[name].tolist()
    assert stated.noisy(recording, 3, 0.0)[LEVEL].tolist() == white[LEVEL].tolist()


def test_a_diagnosis_asks_for_the_bandwidth_once_and_simulates_noise_of_it():
    group = SimpleNamespace(recording="one", entries=[SimpleNamespace(recording="one")])
    small = SimpleNamespace(
        with_effects=lambda *_: None,
        noise_bandwidth=lambda repeats: 70.0 if repeats == [["one"]] else None,
        noisy=lambda recording, count, bandwidth=20.0: {recording: np.full(count, bandwidth)},
    )
    found = asked_bandwidth(small, [group])
    model = Model(small, [group], None, [], bandwidth=found)
    for there in (model, model.of([group], [0])):
        assert there._noisy(group, 2)["one"].tolist() == [70.0, 70.0]
    own = Model(small, [group], None, [], bandwidth=asked_bandwidth(small, []))
    assert own._noisy(group, 1)["one"].tolist() == [20.0]
    assert asked_bandwidth(SimpleNamespace(), [group]) is None
