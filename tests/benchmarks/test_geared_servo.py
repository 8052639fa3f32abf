"""The servo of examples/servo and the truth's, written apart, move alike: bare, and with effects.

Tolerances are 1.5 counts of a 12-bit encoder and twice the noise of a current sensor, in the worst
sample but few: where a shaft comes to rest, and friction decides, a sample may be off by more.
"""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.truth import geared_servo as truth
from hannes.core.recording.recording import Recording
from hannes.plants.protocol import find_plant
from hannes.simulation.catalogue import effects

EXAMPLE = Path(__file__).parents[2] / "examples" / "servo"
TIME = 0.01 * np.arange(500)
COUNT, AMPERES = 2.0 * np.pi / 4096.0, 0.02
SAME = [  # the plant's parameters, the truth's
    ({}, {}),
    ({"command_delay.time": 0.0337}, {"delay": 0.0337}),
    ({"gear_load.coefficient": 0.4}, {"load_share": 0.4}),
    ({"stribeck.torque": 4e-4, "stribeck.speed": 30.0}, {"peak": 0.12, "peak_speed": 0.1}),
    ({"pwm_dead_band.width": 0.05}, {"swallowed": 0.05}),
    ({"supply_sag.resistance": 0.7}, {"source": 0.7}),
]


@pytest.fixture(scope="module")
def plant():
    bare = find_plant("servo:Servo", EXAMPLE)
    known = {**effects(), **bare.catalogue}
    return bare.with_effects(*(each for each in known.values() if not bare.accepts(each)))


def nominal():
    """The truth's servo in the plant's terms: through its gear."""
    n, s = 300.0, truth.SERVO
    return {
        "gear.ratio": n, "motor.inertia": s["inertia"] / n**2,
        "motor.torque_constant": s["constant"] / n, "motor.resistance": s["resistance"],
        "supply.voltage": s["voltage"], "control.gain": s["gain"], "control.limit": s["limit"],
        "motor.dry_friction": s["dry"] / n, "motor.viscous_friction": s["viscous"] / n**2,
        "gravity.torque": s["weight"], "gravity.angle": s["angle"],
    }  # fmt: skip


def commands():
    steps = np.repeat([0.0, 0.7, -0.5, 0.3, 0.1], 100)
    return {"steps": steps, "swing": 1.2 * np.sin(1.4 * TIME)}


@pytest.fixture(scope="module", params=["steps", "swing"])
def asked(request):
    return commands()[request.param]


def both(plant, asked, mine, theirs):
    run = truth.simulate(theirs, TIME, np.array([TIME, asked]))
    units = {"time": "s", "reference": "rad", "position": "rad"}
    recording = Recording({name: run[name] for name in units}, units)
    return plant.simulate({**nominal(), **mine}, recording), run


@pytest.mark.parametrize(("mine", "theirs"), SAME, ids=lambda each: next(iter(each), "none"))
def test_both_servos_move_alike(plant, asked, mine, theirs):
    found, run = both(plant, asked, mine, theirs)
    apart = {name: np.abs(found[name] - run[name]) for name in ("position", "current")}
    assert np.quantile(apart["position"], 0.99) < 1.5 * COUNT
    assert np.sqrt(np.mean(apart["current"] ** 2)) < 2.0 * AMPERES


def test_wrong_gravity_is_a_heavier_load_or_another_mount(plant, asked):
    weight, angle = truth.SERVO["weight"], truth.SERVO["angle"]
    for theirs in ({"heavier": 0.1}, {"tilted": 0.2}):
        more, turned = theirs.get("heavier", 0.0), theirs.get("tilted", 0.0)
        whole = (weight + more) * np.exp(1j * (angle + turned)) - weight * np.exp(1j * angle)
        mine = {"wrong_gravity.sine": whole.real, "wrong_gravity.cosine": whole.imag}
        found, run = both(plant, asked, mine, theirs)
        assert np.quantile(np.abs(found["position"] - run["position"]), 0.99) < 1.5 * COUNT


@pytest.mark.parametrize("gap", [0.003, 0.04])
def test_play_is_crossed_at_the_same_times(plant, asked, gap):
    """Two bodies with springs as faces, and one of them with what the other adds to it.

    Where the shaft strikes a face, samples are off by up to a third of the play.
    """
    mine = {"gear_backlash.gap": gap, "gear_backlash.hold": 0.02}
    found, run = both(plant, asked, mine, {"gap": gap})
    apart = np.abs(found["position"] - run["position"])
    assert np.quantile(apart, 0.98) < 0.5 * COUNT
    assert apart.max() < max(COUNT, gap / 3.0)
    assert np.sqrt(np.mean((found["current"] - run["current"]) ** 2)) < 0.5 * AMPERES
