"""A blow shows for a sample in every force; an outlier in one channel alone."""

from dataclasses import replace

import clean
import numpy as np

from hannes.campaigns.check import check
from hannes.plants.hand.plant import HandPlant

BLOW = 60.0  # N


def grasp(force_blow, sensor_blow):
    """A grasp with one high sample of force and of sensor, at the same time."""
    made = clean.shipped("dynamometer")
    force = made["force"]
    high = np.arange(force.size) == int(np.argmax(force > 0.3 * force.max()))
    blown = {"force": force + force_blow * high, "sensor": made["sensor"] + sensor_blow * high}
    return replace(made, channels={**made.channels, **blown})


def outliers(recording):
    return [each for each in check(recording, HandPlant()) if each.kind == "jump"]


def test_a_high_reading_of_one_sensor_is_an_outlier():
    assert outliers(grasp(BLOW, 0.0))
    assert outliers(grasp(0.0, BLOW))


def test_a_blow_that_both_sensors_show_is_none():
    assert not outliers(grasp(0.0, 0.0))
    assert not outliers(grasp(BLOW, 1.1 * BLOW))


def test_codes_and_dropouts_that_forces_share_are_no_blow():
    made = clean.shipped("dynamometer")
    high = int(np.argmax(made["force"] > 0.9 * made["force"].max()))
    for value in (-9999.0, 0.0):
        broken = {name: made[name].copy() for name in ("force", "sensor")}
        for each in broken.values():
            each[high] = value
        found = outliers(replace(made, channels={**made.channels, **broken}))
        assert {each.channel for each in found} == {"force", "sensor"}


def test_readings_that_differ_are_no_blow():
    assert outliers(grasp(BLOW, -BLOW))
    assert outliers(grasp(4.0 * BLOW, BLOW))
