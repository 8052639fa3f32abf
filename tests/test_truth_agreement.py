"""Two implementations of one hand, written apart, agree where they solve the same equations."""

import numpy as np
import pytest

from benchmarks.truth import NOMINAL, trace
from benchmarks.truth.parameters import named
from hannes.experiment import Experiment, Reference, Target
from hannes.hand import Hand
from hannes.simulate import simulate

KNOTS = [(0.0, 0.0), (0.637, 9.823), (1.022, 0.0)]
OBJECT = {"stiffness": 8344.0, "damping": 59.0, "friction": 0.4, "radius": 26e-3}
PLACE = {"x": 12e-3, "y": -45.5e-3, "z": 0.0}
# State by the library's name -> columns of the truth's.
COLUMNS = {
    "motor_angle": slice(24, 25),
    "motor_speed": slice(25, 26),
    "motor_current": slice(26, 27),
    "cart_position": slice(20, 22),
    "joint_angle": slice(0, 10),
}


def shipped():
    """The library's hand by the truth's names."""
    parameters = Hand().parameters
    return named({name: parameters[name] for name in parameters})


def library(shape, sizes):
    """The library's trajectory of a grasp; sizes: effect -> (parameter, size)."""
    hand = Hand().with_effects(*sizes)
    hand = hand.with_values({f"{name}.{what}": size for name, (what, size) in sizes.items()})
    values = {f"object.{name}": value for name, value in (OBJECT | PLACE).items()}
    experiment = Experiment(
        "agreement",
        1.1,
        Reference(np.array(KNOTS).T),
        object=Target(shape, values) if shape else None,
    )
    return simulate(hand, experiment, method="Radau", rtol=1e-7).require()


def gaps(shape, sizes):
    """Worst difference over the trace as a share of the peak, by name."""
    mine = library(shape, sizes)
    thing = dict(OBJECT, shape=shape, position=tuple(PLACE.values())) if shape else None
    hidden = {name: size for name, (_, size) in sizes.items()}
    channels, states = trace(
        shipped(),
        KNOTS,
        object=thing,
        duration=1.1,
        effects=hidden,
        controller="continuous",
        step_size=25e-6,
    )
    theirs = {name: states[:, place] for name, place in COLUMNS.items()}
    theirs |= {"duty": channels["duty_1"], "force": channels["force_N"]}
    return {
        name: np.abs(mine[name].reshape(value.shape) - value).max() / max(np.abs(value).max(), 1e-9)
        for name, value in theirs.items()
    }


def test_nominal_values_are_the_shipped_hands():
    hand = shipped()
    for name, value in NOMINAL.items():
        assert hand[name] == pytest.approx(value), name


@pytest.mark.parametrize("shape", [None, "cylinder", "sphere"])
def test_same_grasp_same_trace(shape):
    worst = gaps(shape, {})
    assert max(worst.values()) < 5e-5, worst


@pytest.mark.slow
def test_same_hidden_effects_same_trace():
    worst = gaps("cylinder", {"leader_slack": ("length", 3e-3), "gear_load": ("coefficient", 0.05)})
    assert max(worst.values()) < 5e-5, worst


@pytest.mark.slow
def test_direction_friction_differs_only_around_standstill():
    # Each smooths the change of direction in its own way.
    worst = gaps("cylinder", {"direction_friction": ("dry", 0.1)})
    assert max(worst.values()) < 2e-3, worst
