"""The opponents in the race are what they are said to be, and the clock is read fairly."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from runs import worst

from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate

pytest.importorskip("mujoco")

from benchmarks.accuracy_work import TRACES
from benchmarks.mujoco import native, same
from benchmarks.mujoco.elements import Idiom
from benchmarks.peers import cost

HAND, EXPERIMENT = Hand(), load_experiment("dynamometer")[0].experiment


@functools.cache
def exact():
    """The grasp by hannes, converged."""
    return simulate(HAND, EXPERIMENT, rtol=1e-10).require()


@functools.cache
def carried(integrator, every, linearised=False):
    """The same grasp by MuJoCo with our equations."""
    run = same.launch(HAND, EXPERIMENT, integrator, every, linearised)
    return replace(exact(), states=same.states(run()))


def off(run, truth=None):
    """Largest error over the three traces, relative to each peak."""
    return max(worst(run[name], (truth or exact())[name]) for name in TRACES)


@pytest.mark.slow
def test_our_equations_in_mujoco_are_ours():
    """Its fourth-order method at 8 us reaches our converged traces and states."""
    run = carried("RK4", 120)
    assert off(run) < 1e-6
    for name in ("motor_speed", "cart_position", "joint_angle", "joint_speed"):
        assert worst(run[name], exact()[name]) < 1e-5


def test_the_help_adds_what_it_treats_implicitly():
    """The force by the dampings of the step before; contacts damp the joints of their finger."""
    user, rng = np.zeros(same.USER), np.random.default_rng(5)
    user[:] = rng.uniform(0.5, 1.5, user.size)
    steep = same.part.py_func(user, same.STEEP)
    user[same.BOUNDS[same.CHANNEL] + same.PUSH :][:10] = -1.0  # nothing touches
    speeds, before, force = rng.normal(size=(3, same.NV))
    damping, pushed = before.copy(), force.copy()
    same.steepen.py_func(user, speeds, damping, pushed)
    assert pushed == pytest.approx(force + before * speeds, rel=1e-14)
    assert np.array_equal(damping, steep)
    user[same.BOUNDS[same.CHANNEL] + same.PUSH + 2] = 1.0  # the second finger's first phalanx
    same.steepen.py_func(user, speeds, damping, pushed)
    assert np.flatnonzero(damping > steep).tolist() == [5, 6]
    assert np.array_equal(np.delete(damping, [5, 6]), np.delete(steep, [5, 6]))


@pytest.mark.slow
def test_the_help_changes_no_equation():
    """What it treats implicitly it adds again: half the step, half the error."""
    coarse, fine = off(carried("Euler", 20, True)), off(carried("Euler", 40, True))
    assert fine < 3e-3
    assert 1.8 < coarse / fine < 2.2


@pytest.mark.slow
def test_the_help_is_one():
    """Without it, the same step of the same method is far off."""
    assert off(carried("Euler", 20)) > 10 * off(carried("Euler", 20, True))


@functools.cache
def elements(integrator, every, impedance=0.7, limits=True):
    """The grasp in MuJoCo's own elements."""
    run = native.launch(HAND, EXPERIMENT, Idiom(impedance, limits), integrator, every)
    return native.traces(run, HAND)


@pytest.mark.parametrize("limits", (True, False), ids=("limits", "springs"))
def test_own_elements_reproduce_the_grasp(limits):
    """Peaks within 2 %, traces within 6 %, first touch within 20 ms of ours."""
    run = elements("implicitfast", 20, limits=limits)
    for name in TRACES:
        assert run[name].max() == pytest.approx(exact()[name].max(), rel=0.02)
    assert off(run) < 0.06
    touches = [np.argmax(trace["force"] > 1.0) for trace in (run, exact())]
    assert abs(touches[0] - touches[1]) <= 20


def test_own_elements_have_one_limit():
    """Integrators as unlike as two of MuJoCo's tend to the same traces."""
    one, other = elements("Euler", 60, 0.9), elements("implicitfast", 60, 0.9)
    assert off(one, other) < 3e-3


def test_a_run_that_diverges_has_no_trace():
    """It is cut short and counted as not a number, never as quick."""
    assert np.isnan(elements("Euler", 2)["current"]).any()


def test_cost_lies_between_cases():
    """Ten times the time for a hundredth of the error: half a decade between."""
    assert cost([(1.0, 1.0), (10.0, 0.01)], 0.1) == pytest.approx(10**0.5)


def test_cost_follows_the_lower_envelope():
    """A slow and poor case, or one that diverged, carries no information."""
    points = [(1.0, 1.0), (5.0, 3.0), (0.1, float("inf")), (10.0, 0.01)]
    assert cost(points, 0.1) == pytest.approx(10**0.5)


def test_cost_out_of_reach():
    """The quickest case where all are better; not a number where none is good enough."""
    points = [(1.0, 0.5), (10.0, 0.01)]
    assert cost(points, 2.0) == 1.0
    assert np.isnan(cost(points, 1e-3))
