"""measurement_delay: its equation written a second time, its signature in a run."""

import numpy as np
from effect_contract import check_equations, parameter, runs


def test_equation():
    check_equations(
        "measurement_delay",
        {
            "late_position": lambda x, held, sampled, p, q, time: (
                (held - x, 0.0, 0.0)
                if sampled > 0.5
                else (-q, q / time, (12.0 * (x - p) - 6.0 * q) / time)
            ),
            "late_current": lambda x, held, sampled, p, q, time: (
                (held - x, 0.0, 0.0)
                if sampled > 0.5
                else (-q, q / time, (12.0 * (x - p) - 6.0 * q) / time)
            ),
            "age": lambda time: time,
        },
    )


def test_signature():
    _, run = runs("measurement_delay", "finely", time=4e-3)
    ratio, late = parameter("gear.ratio"), 80  # samples of 50 us
    for name, true in (("position", run["motor_angle"] / ratio), ("current", run["motor_current"])):
        logged = run[name]
        assert np.abs(logged[late:] - true[:-late])[200:].max() < 3e-3 * np.ptp(true)
        assert np.abs(logged - true).max() > 5e-3 * np.ptp(true)


def test_signature_of_sampled():
    """By the firmware: exactly."""
    _, run = runs("measurement_delay", "sampled", time=3e-3)
    ratio = parameter("gear.ratio")
    for name, true in (("position", run["motor_angle"] / ratio), ("current", run["motor_current"])):
        gap = np.abs(run[name][3:-1] - true[:-4])  # at the last sample there is no tick
        assert gap.max() < 1e-6 * np.ptp(true)
