"""Simulations: symmetry, convergence, agreement of methods, and how they end."""

import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from runs import GRASP, grasp, reference, run, worst

from hannes.core.errors import BadInput
from hannes.core.kernels.jit import plain
from hannes.core.kernels.vector_math import direction
from hannes.simulation import integrate
from hannes.simulation.batch.simulate_many import simulate_many
from hannes.simulation.experiment.experiment import Experiment, Reference, Target
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Outcome

TRACES = ("current", "force", "leader_tension")
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
PARTS = ("first_length", "second_length", "third_length", "second_mass", "third_mass")


# --- symmetry ---------------------------------------------------------------------------------


def alike(shape, pairs, **values):
    """A grasp with the fingers of each pair made equal; angles, shape (n, 5, 2)."""
    shipped = Hand().parameters
    same = {f"{b}.{part}": shipped[f"{a}.{part}"] for a, b in pairs for part in PARTS}
    experiment = Experiment("alike", 0.5, reference(GRASP), Target(shape, values))
    found = simulate(Hand().with_values(same), experiment, rtol=1e-8).require()
    assert found["force"].max() > 10.0
    return found, found["joint_angle"].reshape(-1, 5, 2)


def test_equal_fingers_move_alike():
    pairs = [("index", other) for other in ("middle", "ring", "little")]
    found, angles = alike("cylinder", pairs)
    for finger in range(1, 4):
        assert np.abs(angles[:, finger] - angles[:, 0]).max() < 1e-7
    assert np.abs(found["cart_position"] @ [1.0, -1.0]).max() < 1e-9
    forces = found["phalanx_force"].reshape(-1, 5, 2)[:, :4]
    assert np.ptp(forces, axis=1).max() < 1e-6 * found["force"].max()


def test_fingers_mirrored_about_a_ball_move_alike():
    pairs = [("index", "little"), ("middle", "ring")]
    _, angles = alike("sphere", pairs, **{"object.radius": 0.04, "object.z": 0.0})
    for finger, mirrored in ((0, 3), (1, 2)):
        assert np.abs(angles[:, finger] - angles[:, mirrored]).max() < 1e-7
    assert np.abs(angles[:, 0] - angles[:, 1]).max() > 1e-3


def test_mirrored_hand_moves_alike():
    """All fingers facing the other way, object and gravity mirrored: the same motion."""
    shipped, heavy = Hand().parameters, {"gravity.x": 2.0, "gravity.y": -9.0}
    names = ["gravity.y", "object.y"]
    names += [f"{finger}.{what}" for finger in FINGERS for what in ("facing", "mount_y")]
    values = {**shipped, **heavy}
    mirrored = heavy | {name: -values[name] for name in names}
    mine, theirs = (
        simulate(Hand(), replace(grasp(duration=0.5), values=each), rtol=1e-8).require()
        for each in (heavy, mirrored)
    )
    for name in (*TRACES, "joint_angle", "cart_position"):
        assert np.abs(mine[name] - theirs[name]).max() <= 1e-8 * np.abs(mine[name]).max()


# --- accuracy ---------------------------------------------------------------------------------


def errors(method, rtol, name):
    """Worst and RMS error of a trace as a share of its range, against a converged run."""
    mine, exact = run(method=method, rtol=rtol)[name], run(rtol=1e-10)[name]
    return worst(mine, exact), float(np.sqrt(np.mean((mine - exact) ** 2)) / np.ptp(exact))


@pytest.mark.parametrize("name", TRACES)
@pytest.mark.parametrize("method", ["Rodas", "LSODA", "BDF", "Radau"])
def test_errors_fall_as_tolerances_tighten(method, name):
    """RMS errors from one decade to the next; the worst instant's, a matter of luck, over two."""
    off, rms = np.array([errors(method, rtol, name) for rtol in TOLERANCES]).T
    assert (np.diff(rms) < 0.0).all()
    assert (off[2:] < off[:-2]).all()
    assert off[1] < 2e-3 and off[-1] < 5e-6


@pytest.mark.parametrize("name", TRACES)
def test_methods_agree(name):
    lsoda, radau, bdf = (run(method=m, rtol=1e-8)[name] for m in ("LSODA", "Radau", "BDF"))
    assert worst(lsoda, radau) < 2e-7
    assert worst(bdf, radau) < 2e-7


def test_rigid_and_soft_are_one_until_the_first_touch():
    rigid, soft = run(rtol=1e-6), run(rtol=1e-6, stiffness=800.0)
    touch = int(np.argmax(rigid["force"] > 0.0))
    assert touch > 200 and soft["force"][touch] > 0.0
    for name in (*TRACES, "joint_angle", "joint_speed", "motor_angle"):
        before = rigid[name][:touch]
        assert np.abs(before - soft[name][:touch]).max() <= 1e-6 * np.abs(before).max()
    assert rigid["force"].max() > 1.5 * soft["force"].max()


# --- effects at off ---------------------------------------------------------------------------


def test_an_effect_at_off_is_left_out():
    bare, dressed = Hand(), Hand().with_effects("leader_slack", "gear_load")
    assert dressed.present_effects() == ()
    assert dressed.compiled() is bare.compiled()
    assert dressed.equations() == bare.equations()


@pytest.mark.slow
def test_an_effect_compiled_in_at_off_changes_no_bit():
    """One is compiled here; that none moves a rate, test_hand_jacobian.py shows of each."""
    hand = Hand().with_effects("leader_slack")
    mine = simulate(hand, grasp(), effects=hand.effects)
    assert mine.compiled is not run().compiled
    assert np.array_equal(mine.states, run().states)
    assert np.array_equal(mine.outputs, run().outputs)


# --- cost -------------------------------------------------------------------------------------


def test_steps_without_end_are_reported(monkeypatch):
    monkeypatch.setattr("hannes.simulation.integrate.MOST", 20)
    found = simulate(Hand(), grasp(), rtol=1e-6)
    assert found.outcome is Outcome.SOLVER_GAVE_UP and "More steps" in found.message
    assert 0 < found.time.size < grasp().times.size


def test_seconds_leave_out_what_is_done_once(monkeypatch):
    """Compiling takes many times what a grasp does."""
    solved, first = integrate.Initial._solve, [0.3]

    def slow_at_first(self, *given):
        time.sleep(first.pop() if first else 0.0)
        return solved(self, *given)

    monkeypatch.setattr(integrate, "_ready", set())
    monkeypatch.setattr(integrate.Initial, "_solve", slow_at_first)
    assert simulate(Hand(), grasp()).cost.seconds < 0.3 and not first


# --- references and controllers ---------------------------------------------------------------


def test_restarts_at_every_kink():
    parts = reference(GRASP).segments(1.15)
    assert [part[:2] for part in parts] == [(0.0, 0.637), (0.637, 1.022), (1.022, 1.15)]
    assert run().cost.steps == 3
    times = np.arange(0.0, 1.1501, 1e-3)
    for part in parts:
        start, end, knots = part
        inside = times[(times >= start) & (times <= end)]
        expected = np.interp(inside, *np.array(GRASP).T)
        assert np.interp(inside, *knots) == pytest.approx(expected, abs=1e-12)


def test_a_step_of_the_reference_is_a_kink():
    points = ((0.0, 0.0), (0.1, 0.0), (0.1, 2.0), (0.3, 2.0))
    experiment = replace(grasp(None, 0.3), reference=reference(points))
    found = simulate(Hand(), experiment).require()
    assert np.abs(found["current"][found.time < 0.1]).max() < 1e-9
    assert found["current"][found.time > 0.101].max() > 0.5
    assert found.time.size == 301 and found.time[-1] == pytest.approx(0.3)


def test_a_step_at_the_start_is_there_from_the_start():
    experiment = replace(
        grasp(None, 0.1), reference=reference(((0.0, 0.0), (0.0, 2.0), (1.0, 2.0)))
    )
    assert (simulate(Hand(), experiment).require()["reference"] == 2.0).all()


@pytest.mark.parametrize("duration, last", [(0.0207, 0.02), (0.0204, 0.02), (0.021, 0.021)])
def test_no_sample_lies_beyond_the_duration(duration, last):
    found = simulate(Hand(), grasp(None, duration)).require()
    assert found.time[-1] == pytest.approx(last, abs=1e-12) and found.time[-1] <= duration
    longer = simulate(Hand(), grasp(None, 0.03), rtol=1e-8).require()
    angle = found["motor_angle"]
    assert angle == pytest.approx(longer["motor_angle"][: angle.size], abs=1e-3 * angle.max())


def test_the_controller_is_set_once():
    with pytest.raises(BadInput, match='controller = "sampled"'):
        replace(grasp(), values={"controller.sampled": 1.0})
    with pytest.raises(BadInput, match='controller = "sampled"'):
        list(simulate_many(Hand(), grasp(), {"controller.sampled": [0.0, 1.0]}, channels=["force"]))


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_a_recorded_reference_gives_the_same_run(rtol):
    """The same lines as many samples, integrated without restarts."""
    times = np.arange(0.0, 1.151, 1e-3)
    recorded = np.array([times, np.interp(times, *np.array(GRASP).T)])
    experiment = replace(grasp(), reference=Reference(recorded, kinked=False))
    found = simulate(Hand(), experiment, rtol=rtol).require()
    assert found.cost.steps == 1
    for name in TRACES:
        assert worst(found[name], run(rtol=1e-10)[name]) < 20.0 * rtol


def test_the_sampled_controller_approaches_the_continuous_one():
    fine = {"controller.period": 2e-4, "controller.speed_weight": 0.08, "encoder.bits": 18.0}
    sampled = grasp(duration=0.7, controller="sampled")
    for values, allowed in (({}, 0.03), (fine, 3e-3)):
        found = simulate(Hand(), replace(sampled, values=values)).require()
        for name in TRACES:
            assert worst(found[name], run(rtol=1e-6)[name][: found.time.size]) < allowed


def test_ticks_keep_their_jacobian_and_are_right():
    """Beside LSODA from tick to tick; an encoder that counts finely sets off no other duty."""
    values = {"encoder.bits": 30.0}
    experiment = replace(grasp(duration=0.45, controller="sampled"), values=values)
    found = simulate(Hand(), experiment, rtol=1e-3).require()
    exact = simulate(Hand(), experiment, method="LSODA", rtol=1e-8).require()
    assert found.cost.jacobians < 0.4 * found.cost.steps
    for name in TRACES:
        off = (found[name] - exact[name]) / np.abs(exact[name]).max()
        assert np.sqrt(np.mean(off**2)) < 1e-3, name


def test_the_duty_is_held_between_ticks():
    experiment = replace(grasp(duration=0.05, controller="sampled"), sampling=10_000.0)
    duty = simulate(Hand(), experiment).require()["duty"]
    assert duty.size == 501
    assert (np.ptp(duty[:-1].reshape(-1, 10), axis=1) == 0.0).all()
    assert np.unique(duty).size > 30


# --- ends -------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["BDF", "Radau"])
def test_a_jacobian_that_is_not_finite_keeps_the_solvers_words(monkeypatch, method):
    runner = sys.modules["hannes.simulation.integrate"].Initial
    monkeypatch.setattr(
        runner, "_method", lambda self, knots: {"method": self.method, "jac": not_finite}
    )
    found = simulate(Hand(), grasp(duration=0.1), method=method)
    assert found.outcome is Outcome.NOT_FINITE
    assert "infs or NaNs" in found.message


def not_finite(time, state):
    """A Jacobian without a finite entry."""
    return np.full((state.size, state.size), np.nan)


def test_an_angle_that_is_no_number_has_no_direction():
    with np.errstate(invalid="ignore"):
        found = [plain(direction)(each) for each in (np.nan, np.inf)]
    assert np.isnan(found).all() and np.isnan(direction(np.nan)).all()


@pytest.mark.parametrize("rtol", [0.0, 1.0, -1e-3, 1e-14, float("nan")])
def test_bad_tolerances_are_refused(rtol):
    with pytest.raises(BadInput, match="rtol"):
        simulate(Hand(), grasp(), rtol=rtol)


def test_an_unknown_method_is_refused_with_the_nearest():
    with pytest.raises(BadInput, match="LSODA"):
        simulate(Hand(), grasp(), method="LSOD")
