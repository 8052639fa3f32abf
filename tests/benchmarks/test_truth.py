"""The independent second hand: closed forms, energy, convergence."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from benchmarks.truth import NOMINAL, simulate, trace
from benchmarks.truth.bench import CURRENT, FORCE
from benchmarks.truth.finger import finger
from benchmarks.truth.laws import friction, one_sided
from benchmarks.truth.protocol import DYNAMOMETER, SOFT_BALL

GRASP = [(0.0, 0.0), (0.637, 9.823), (1.022, 0.0)]
FIXED = 1e9  # a tolerance that any step meets
JOINTS = ("mcp", "pip")
FRICTIONS = ("breakaway_friction", "coulomb_friction", "viscous_friction")


def loose_fingers(**changes):
    """Fingers without friction, springs, stops or wires: pendulums in a plane."""
    parts = (*FRICTIONS, "spring_stiffness", "spring_preload", "stop_damping")
    out = {f"{joint}.{part}": 0.0 for joint in JOINTS for part in parts}
    out |= {f"{joint}.stop_stiffness": 1e-12 for joint in JOINTS}
    out |= {"follower.stiffness": 0.0, "follower.damping": 0.0}
    out |= {"leader.stiffness": 0.0, "leader.damping": 0.0}
    return out | changes


def hold(parameters, **options):
    """The hand left alone at reference 0: channels, states."""
    return trace(parameters, [(0.0, 0.0), (1.0, 0.0)], controller="continuous", **options)


def test_accelerations_are_those_of_the_textbook_double_pendulum():
    rng = np.random.default_rng(3)
    l1, l2, m1, m2, g = 0.044, 0.05, 0.015, 0.012, 9.81
    law = (0.0, 0.0, 0.0, 1e-4, 5e-3, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    disc = (0.0, 0.0, 0.0, 8e-3, 0.0, 0.0)
    for _ in range(20):
        q1, q2 = rng.uniform(-2, 2, 2)
        w1, w2, t1, t2 = rng.uniform(-20, 20, 4) * (1, 1, 1e-3, 1e-3)
        a, v = q1 + q2, w1 + w2
        rods = ((l1, l2), (m1, m2), (g, 0.0), disc, law, (0.0, 0.0), 0.0)
        (b1, b2), _, force, _ = finger((q1, q2), (w1, w2), (t1, t2), *rods)
        # Lagrange in the absolute angles q1 and a, uniform rods, gravity along x.
        c = m2 * l1 * l2 / 2
        row1 = (m1 / 3 + m2) * l1**2 * b1 + c * np.cos(a - q1) * (b1 + b2)
        row1 += -c * np.sin(a - q1) * v**2 + (m1 / 2 + m2) * g * l1 * np.sin(q1)
        row2 = m2 * l2**2 / 3 * (b1 + b2) + c * np.cos(a - q1) * b1
        row2 += c * np.sin(a - q1) * w1**2 + m2 / 2 * g * l2 * np.sin(a)
        np.testing.assert_allclose([row1, row2], [t1 - t2, t2], atol=1e-12)
        assert force == 0.0


def test_finger_with_a_weightless_tip_swings_with_the_rods_period():
    small = 0.01
    light = {"fingers.distal_mass": (1e-9,) * 5, "fingers.mcp_rest": (small,) * 5}
    hanging = loose_fingers(**light, **{"gravity.x": 9.81, "fingers.pip_rest": (0.0,) * 5})
    channels, states = hold(hanging, duration=0.5)
    rate = np.sqrt(1.5 * 9.81 / np.array(NOMINAL["fingers.proximal_length"]))
    expected = small * np.cos(np.outer(channels["time_s"], rate))
    np.testing.assert_allclose(states[:, 0:10:2], expected, atol=2e-3 * small)


def energy(parameters, states, f, disc=None):
    """Kinetic, gravity (along x) and contact energy (J) of finger f from endpoint positions."""
    l1, l2, m1, m2 = (
        NOMINAL[f"fingers.{name}"][f]
        for name in ("proximal_length", "distal_length", "proximal_mass", "distal_mass")
    )
    q1, a = states[:, 2 * f], states[:, 2 * f] + states[:, 2 * f + 1]
    w1, v = states[:, 10 + 2 * f], states[:, 10 + 2 * f] + states[:, 11 + 2 * f]
    knee = l1 * np.exp(-1j * q1)
    tip = knee + l2 * np.exp(-1j * a)
    speed = np.abs(w1 * knee + 0.5 * v * (tip - knee))
    total = m1 * l1**2 * w1**2 / 6 + m2 * speed**2 / 2 + m2 * l2**2 * v**2 / 24
    total -= parameters["gravity.x"] * (m1 * knee.real / 2 + m2 * (knee + tip).real / 2)
    for start, end in ((0 * knee, knee), (knee, tip)) if disc else ():
        along = ((disc["centre"] - start) * np.conj(end - start)).real / np.abs(end - start) ** 2
        gap = np.abs(disc["centre"] - start - np.clip(along, 0, 1) * (end - start))
        depth = np.maximum(0, disc["radius"] + NOMINAL["fingers.radius"][f] - gap)
        total += disc["stiffness"] * depth**2 / 2
    return total


def test_a_finger_bouncing_on_a_lossless_disc_keeps_its_energy():
    disc = dict(DYNAMOMETER, stiffness=2000.0, damping=0.0, friction=0.0)
    falling = loose_fingers(**{"gravity.x": 9.81, "fingers.mcp_rest": (-0.7,) * 5})
    falling["fingers.pip_rest"] = (-0.2,) * 5
    disc["position"] = (50e-3, -35e-3, 0.0)
    channels, states = hold(falling, duration=0.4, object=disc, tolerance=1e-5)
    plane = {"centre": 50e-3 - 35e-3j, "radius": 26e-3, "stiffness": 2000.0}
    for f in range(4):
        held = energy(falling, states, f, plane)
        swing = np.ptp(energy(falling, states, f) - held)
        assert channels["force_N"].max() > 1.0
        assert swing > 1e-3
        assert np.ptp(held) < 1e-3 * swing


def test_free_motor_follows_the_linear_step_response():
    free = {"motor.dry_friction": 0.0, "position_pid.proportional": 1e6, "position_pid.limit": 1e6}
    loose = {"leader_slack.length": 1.0}
    channels, states = trace(
        free, [(0.0, 1e3), (1.0, 1e3)], effects=loose, controller="continuous", tolerance=1e-5
    )
    k, r, henry, j, b = (
        NOMINAL[f"motor.{name}"]
        for name in ("torque_constant", "resistance", "inductance", "inertia", "viscous_friction")
    )
    system = np.array(
        [[-r / henry, -k / henry, 12.0 / henry], [k / j, -b / j, 0.0], [0.0, 0.0, 0.0]]
    )
    step = np.array([expm(system * t)[:2, 2] for t in channels["time_s"][:100]])
    np.testing.assert_allclose(channels["duty_1"][:100], 1.0)
    np.testing.assert_allclose(states[:100, 26], step[:, 0], atol=5e-4 * 12.0 / r)
    np.testing.assert_allclose(states[:100, 25], step[:, 1], atol=5e-4 * 12.0 / k)


def test_laws_of_one_variable():
    speeds = np.linspace(0.0, 30e-3, 3001)
    beyond = [friction(v, 3.0, 1.0, 1e-2, 0.0) - friction(v, 1.0, 1.0, 1e-2, 0.0) for v in speeds]
    assert speeds[np.argmax(beyond)] == pytest.approx(1e-2)
    assert max(beyond) == pytest.approx(2.0)
    assert one_sided(-1e-6, 1.0, 6e4, 30.0, 20e-6) == 0.0
    assert one_sided(1e-3, -10.0, 6e4, 30.0, 20e-6) == 0.0  # never pulls
    assert one_sided(1e-3, 1.0, 6e4, 30.0, 20e-6) == pytest.approx(90.0)


def test_rest_is_an_equilibrium():
    _, states = hold({}, duration=0.3)
    np.testing.assert_allclose(states, np.tile(states[0], (len(states), 1)), atol=1e-12)


def grasp(**options):
    usual = {"object": DYNAMOMETER, "duration": 0.9, "controller": "continuous"}
    return simulate({}, GRASP, **{**usual, **options})


def errors(rough, fine):
    """Worst and RMS difference over the fine one's peak, by channel."""
    gap = {name: np.abs(rough[name] - value) for name, value in fine.items()}
    return {
        name: (gap[name].max() / peak, np.sqrt(np.mean(gap[name] ** 2)) / peak)
        for name, value in fine.items()
        if (peak := np.abs(value).max()) > 0.0
    }


def test_errors_fall_as_the_square_of_the_step():
    fine, coarse, half = (
        grasp(tolerance=FIXED, longest=step) for step in (12.5e-6, 250e-6, 125e-6)
    )
    coarse, half = errors(coarse, fine), errors(half, fine)
    for name in ("position_rad", "current_A", "duty_1", "force_N", "sensor_N"):
        assert half[name][1] < 2e-5
        assert coarse[name][1] / half[name][1] > 3.0, name  # 4 for order two; stiff parts gain more


@pytest.mark.parametrize("thing", [None, DYNAMOMETER, SOFT_BALL])
def test_a_campaigns_runs_are_converged_far_below_the_sensors(thing):
    # With a fine encoder, so that no count falls the other way: what is left is integration error.
    options = {"object": thing, "duration": 1.15}
    fine = simulate({"encoder.bits": 30.0}, GRASP, tolerance=1e-7, **options)
    ran = simulate({"encoder.bits": 30.0}, GRASP, **options)
    for name, (worst, _) in errors(ran, fine).items():
        assert worst < 1e-3, name
    assert np.abs(ran["current_A"] - fine["current_A"]).max() < 0.1 * CURRENT
    assert np.abs(ran["force_N"] - fine["force_N"]).max() < 0.5 * FORCE


def test_encoder_counts_that_fall_the_other_way_stay_below_the_sensors():
    fine, ran = (grasp(controller="sampled", tolerance=each) for each in (1e-7, 1e-3))
    gap = ran["current_A"] - fine["current_A"]
    assert np.sqrt(np.mean(gap**2)) < 0.3 * CURRENT
    assert np.abs(gap).max() < 25e-3  # what one count does to the current demand
    assert np.abs(ran["force_N"] - fine["force_N"]).max() < FORCE


def test_dynamometer_grasp_has_the_designs_size():
    base = grasp()
    assert 2.0 < base["current_A"].max() < 2.6
    assert 170.0 < base["force_N"].max() < 200.0
    ball = grasp(object=dict(DYNAMOMETER, stiffness=800.0))
    assert ball["current_A"].max() < 0.6 * base["current_A"].max()
    # Up to the first touch, no object acts.
    before = slice(0, int(np.argmax(base["force_N"] > 0.0)) - 1)
    for name, values in base.items():
        np.testing.assert_allclose(values[before], ball[name][before], atol=1e-9)


def test_fast_sampling_of_a_fine_encoder_tends_to_the_continuous_controller():
    continuous = grasp()
    differences = []
    for period in (2e-4, 1e-4):
        every = round(1e-3 / period)
        fast = {"controller.period": period, "encoder.bits": 30.0}
        fast["controller.speed_weight"] = 1.0 - np.exp(-period / NOMINAL["position_pid.filter"])
        sampled = simulate(fast, GRASP, object=DYNAMOMETER, duration=0.9)
        gap = sampled["current_A"][::every] - continuous["current_A"]
        differences.append(np.sqrt(np.mean(gap**2)))
    assert differences[0] < 0.02
    assert differences[1] < 0.6 * differences[0]


def test_firmware_sampling_stays_close_to_the_continuous_controller():
    continuous, sampled = grasp(), grasp(controller="sampled")
    gap = sampled["current_A"] - continuous["current_A"]
    assert np.sqrt(np.mean(gap**2)) < 0.05
    counts = sampled["position_rad"] * 4096 / (2 * np.pi)
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)


def test_slack_delays_the_fingers_and_none_is_absent():
    quick = {"controller": "continuous", "duration": 0.3}
    taut = trace({}, GRASP, **quick)[1]
    loose = trace({}, GRASP, effects={"leader_slack.length": 3e-3}, **quick)[1]
    arm = NOMINAL["gear.pulley_radius"] / NOMINAL["gear.ratio"]
    # Wire wound up by the time that the first cart moves: longer by the slack.
    wound = [arm * states[np.argmax(states[:, 20] > 1e-4), 24] for states in (taut, loose)]
    assert wound[1] - wound[0] == pytest.approx(3e-3, rel=0.05)
    off = trace({}, GRASP, effects={"leader_slack.length": 0.0}, **quick)[1]
    assert np.array_equal(off, taut)


def test_truth_imports_nothing_numerical_of_the_library():
    allowed = {
        "hannes.core.errors",
        "hannes.core.io.atomic_files",
        "hannes.core.recording.recording",
    }
    folder = Path(__file__).parents[2] / "benchmarks" / "truth"
    for source in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            names = [getattr(node, "module", None) or ""]
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            for name in names:
                assert name.split(".")[0] != "hannes" or name in allowed, source
    code = (
        "import sys, benchmarks.truth.campaign; "
        "print(*(name for name in sys.modules if name.startswith('hannes.')))"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=folder.parents[1], capture_output=True
    ).stdout.decode()
    packages = {"hannes.core", "hannes.core.io", "hannes.core.recording", "hannes.report"}
    # What these bring along: names, marks of files, limits and checks of samples; no mechanics.
    brought = {
        *("hannes.core.former_names", "hannes.core.former_modules", "hannes.core.version"),
        *("hannes.core.io.limits", "hannes.core.io.bounded", "hannes.core.io.inputs"),
        "hannes.core.io.json_text",
        *("hannes.core.io.result_marks", "hannes.core.recording.soundness", "hannes.report.bound"),
    }
    assert set(loaded.split()) <= allowed | packages | brought


def test_compiled_equals_plain_python():
    code = (
        "from benchmarks.truth import trace; "
        "print(trace({}, [(0, 0), (0.01, 0.1)], duration=0.01)[1][-1].tolist())"
    )
    plain, quick = (
        subprocess.run(
            [sys.executable, "-c", code],
            check=True,
            capture_output=True,
            text=True,
            cwd=Path(__file__).parents[2],
            env={**os.environ, "NUMBA_DISABLE_JIT": switch},
        ).stdout
        for switch in ("1", "0")
    )
    np.testing.assert_allclose(json.loads(plain), json.loads(quick), rtol=1e-7, atol=1e-9)
