"""Each hidden effect of the truth: declared, absent at 0, and what its equation says."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.truth import NOMINAL, effects, trace
from benchmarks.truth._jit import inlined
from benchmarks.truth.added import summed
from benchmarks.truth.bench import CURRENT, FORCE
from benchmarks.truth.controller import encoder
from benchmarks.truth.effects import (
    SIZES,
    capstan,
    direction_friction,
    eccentric_pulley,
    friction_step,
    gear_backlash,
    gear_load,
    hunt_crossley,
    nonlinear_spring,
    pwm_dead_band,
    spring_error,
    spring_hysteresis,
    stribeck,
    torque_ripple,
    winding_heating,
    wire_compliance,
)
from benchmarks.truth.finger import pressed
from benchmarks.truth.laws import held
from benchmarks.truth.protocol import DYNAMOMETER, PAPER, SOFT_BALL, scaled
from benchmarks.truth.record import pack
from benchmarks.truth.state import CART_SPEED, MOTOR, SENSED, SHAFT
from benchmarks.truth.state import CURRENT as WINDING
from benchmarks.truth.wires import leader_pulls

AMPLITUDES = [name for name, size in SIZES.items() if size.amplitude]
OTHERS = {name: size.high for name, size in SIZES.items() if not size.amplitude}


TIGHT = ({"tolerance": 1e-6}, {})


def hand(**sizes):
    """The kernels' record with effects, their names' dots as double underscores."""
    return pack({}, effects={name.replace("__", "."): x for name, x in sizes.items()})


def run(sizes=None, thing=None, points=PAPER, **options):
    return trace({}, points, object=thing, effects=sizes, duration=points[-1][0] + 0.1, **options)


@pytest.mark.parametrize("effect", [*effects.CATALOGUE, *effects.OUTSIDE])
def test_every_effect_says_its_equation_source_and_range(effect):
    for part in ("\n\n    ", "Source:", "Range:"):
        assert part in effect.__doc__


def test_the_table_lists_every_parameter_with_its_unit_and_range():
    rows = dict(line.split("  ", 1) for line in effects.table().splitlines())
    assert [name.strip() for name in rows] == list(SIZES)
    assert "m          0.0002 to 0.008" in effects.table()
    assert "rad/s      5 to 60  (default 20)" in effects.table()


def adding(**functions):
    return SimpleNamespace(**{name: inlined(each) for name, each in functions.items()})


def test_what_files_add_to_a_quantity_is_summed():
    one = adding(loose_length=lambda h, shaft: 2.0 * shaft)
    two = adding(loose_length=lambda h, shaft: h + shaft, bus_drop=lambda h, duty, current: 1.0)
    assert summed("loose_length", [])(5.0, 7.0) == 0.0
    assert summed("loose_length", [one])(5.0, 7.0) == 14.0
    assert summed("loose_length", [one, two])(5.0, 7.0) == 26.0
    assert summed("bus_drop", [one, two])(5.0, 7.0, 9.0) == 1.0


def test_at_size_0_nothing_is_changed_wherever_it_would_act():
    base, same = run(thing=DYNAMOMETER), run(OTHERS, DYNAMOMETER)
    assert np.array_equal(base[1], same[1])


@pytest.fixture(scope="module")
def bare():
    """Channels of the hand without effects, at each object and in the air."""
    return [(thing, run(thing=thing)[0]) for thing in (DYNAMOMETER, SOFT_BALL, None)]


@pytest.mark.parametrize("name", AMPLITUDES)
def test_every_effect_shows_at_its_largest_physical_size(bare, name):
    noise = {"position_rad": 1.5e-3, "current_A": CURRENT, "duty_1": 3e-3}
    noise |= {"force_N": FORCE, "sensor_N": FORCE}

    def shows(base, changed):
        return any(np.sqrt(np.mean((changed[c] - base[c]) ** 2)) > x for c, x in noise.items())

    assert any(shows(base, run({name: SIZES[name].high}, thing)[0]) for thing, base in bare)


@pytest.mark.parametrize("name", AMPLITUDES)
def test_every_effect_at_its_largest_is_integrated_far_below_the_sensors(name):
    hidden = {**OTHERS, name: SIZES[name].high}
    for thing in (None, DYNAMOMETER):
        options = {"object": thing, "effects": hidden, "duration": 1.1}
        fine, rough = (trace({"encoder.bits": 30.0}, PAPER, **options, **t)[0] for t in TIGHT)
        assert np.abs(fine["current_A"] - rough["current_A"]).max() < 0.2 * CURRENT
        assert np.abs(fine["force_N"] - rough["force_N"]).max() < 0.5 * FORCE


def test_wires_in_series_share_their_stretch():
    soft = wire_compliance.in_series(6e4, 1e-5)
    assert 100.0 / soft == pytest.approx(100.0 / 6e4 + 100.0 * 1e-5)


def test_a_half_turn_passes_what_euler_says():
    h = hand(capstan__friction=0.1)
    assert capstan.passed(h, 50.0, 1.0) == pytest.approx(50.0 * math.exp(-0.1 * math.pi))
    assert capstan.passed(h, 50.0, -1.0) == pytest.approx(50.0 * math.exp(0.1 * math.pi))
    one, two = capstan.shared(h, 50.0, 1.0)
    assert one + two == pytest.approx(100.0)
    assert two / one == pytest.approx(math.exp(0.1 * math.pi))


def test_the_leader_loses_pull_at_three_pulleys_on_its_way():
    h, y = hand(capstan__friction=0.1), np.zeros(56)
    y[CART_SPEED], y[CART_SPEED + 1] = 1.0, 1.0
    drop = math.exp(-0.1 * math.pi)
    at_a, at_b, thumb = leader_pulls(h, y, 10.0)
    assert at_a == pytest.approx(10.0 * (1.0 + drop))
    assert at_b == pytest.approx(10.0 * (drop**2 + drop**3))
    assert thumb == pytest.approx(10.0 * drop**3)


def test_drive_frictions_of_one_speed():
    assert gear_load.lost(hand(gear_load__coefficient=0.1), -0.5) == pytest.approx(0.05)
    sizes = {"direction_friction__dry": 0.1, "direction_friction__viscous": 0.2}
    assert direction_friction.shares(hand(**sizes), -1.0) == pytest.approx((0.9, 0.8))
    h = hand(stribeck__torque=2e-3, stribeck__speed=15.0)
    speeds = np.linspace(0.0, 60.0, 6001)
    torques = [stribeck.peak(h, w) for w in speeds]
    assert max(torques) == pytest.approx(2e-3)
    assert speeds[np.argmax(torques)] == pytest.approx(15.0)
    assert stribeck.peak(h, -15.0) == pytest.approx(-2e-3)


def test_backlash_leaves_the_shaft_behind_by_half_the_gap():
    _, states = run({"gear_backlash.gap": 40e-3})
    lead = states[:, MOTOR] / 19 - states[:, SHAFT]
    assert lead[200:1000] == pytest.approx(20e-3, abs=0.3e-3)  # the teeth give 0.1 mrad
    first = np.argmax(states[:, SHAFT] > 1e-4)
    assert states[first, MOTOR] / 19 > 20e-3
    assert gear_backlash.teeth(hand(gear_backlash__gap=40e-3), 19.9e-3, 100.0) == 0.0
    assert gear_backlash.teeth(hand(gear_backlash__gap=40e-3), -21e-3, 0.0) == pytest.approx(-0.3)


def test_no_gap_is_a_rigid_gear():
    base, almost = run(thing=DYNAMOMETER)[0], run({"gear_backlash.gap": 1e-9}, DYNAMOMETER)[0]
    assert np.sqrt(np.mean((base["current_A"] - almost["current_A"]) ** 2)) < 0.3 * CURRENT
    assert np.abs(base["position_rad"] - almost["position_rad"]).max() < 2e-3  # one count


def test_cogging_does_no_work_over_a_turn():
    h = hand(torque_ripple__amplitude=1e-3, torque_ripple__cycles=6.0, torque_ripple__phase=0.3)
    torques = [torque_ripple.cogging(h, a) for a in np.linspace(0, 2 * np.pi, 600, endpoint=False)]
    assert np.mean(torques) == pytest.approx(0.0, abs=1e-18)
    assert max(torques) == pytest.approx(1e-3, rel=1e-3)
    assert np.abs(np.fft.rfft(torques)).argmax() == 6


def test_a_warm_motor():
    h = hand(winding_heating__rise=50.0)
    assert winding_heating.resistance(h) == pytest.approx(3.084 * 1.1965)
    assert winding_heating.torque_constant(h) == pytest.approx(18.08e-3 * 0.945)


def test_the_bus_sags_by_what_is_drawn():
    channels, states = run({"supply_sag.resistance": 1.0}, DYNAMOMETER)
    drawn = channels["duty_1"] * states[:, WINDING]
    np.testing.assert_allclose(channels["supply_V"], 12.0 - drawn, atol=1e-9)
    assert channels["supply_V"].min() < 11.0


def test_small_duties_are_lost_in_the_dead_band():
    h = hand(pwm_dead_band__width=0.05)
    passed = [pwm_dead_band.passed(h, duty) for duty in (-0.3, -0.04, 0.0, 0.05, 0.2)]
    assert passed == pytest.approx([-0.25, 0.0, 0.0, 0.0, 0.15])


def test_springs():
    assert spring_error.real(hand(spring_error__share=-0.1), 2.0) == pytest.approx(1.8)
    assert nonlinear_spring.stiffening(hand(nonlinear_spring__cubic=0.01), 2.0) == pytest.approx(
        0.08
    )
    # Dahl's law along a slow way there and back: an exponential in the way, whatever the speed.
    h = hand(spring_hysteresis__share=0.1, spring_hysteresis__width=0.05)
    for speed in (0.1, 3.0):
        z, step = 0.0, 1e-5 / speed
        for _ in range(10000):
            z = held(z, step, *spring_hysteresis.dahl(h, speed))
        assert z == pytest.approx(1.0 - math.exp(-0.1 / 0.05), abs=1e-3)
    assert spring_hysteresis.lost(h, 2.0, -1.0) == pytest.approx(-0.2)


def test_hunt_and_crossley_without_both_is_hooke_and_keeps_k_at_1_mm():
    assert hunt_crossley.elastic(2e-3, 0.5, 1e4, 0.0, 0.0) == pytest.approx(20.0)
    assert hunt_crossley.elastic(1e-3, 0.0, 1e4, 0.5, 0.0) == pytest.approx(10.0)
    assert hunt_crossley.elastic(4e-3, 0.0, 1e4, 0.5, 0.0) == pytest.approx(80.0)
    assert hunt_crossley.elastic(1e-3, 0.2, 1e4, 0.5, 1.5) == pytest.approx(13.0)


def test_a_creeping_object_under_a_constant_depth_relaxes_as_the_standard_linear_solid():
    stiffness, depth, share, time = 1e4, 2e-3, 0.6, 0.1
    law = (stiffness, 0.0, 0.0, 1e-4, 5e-3, 0.0, 0.0, share, time, 0.0, 0.0)
    dent, step = 0.0, 1e-4
    for _ in range(1000):
        force, dent, _ = pressed(depth, 0.0, law, dent, step)
    settled = share * depth / (1.0 + share)
    expected = settled * (1.0 - math.exp(-(1.0 + share) * 0.1 / time))
    assert dent == pytest.approx(expected, rel=2e-3)
    assert force == pytest.approx(stiffness * (depth - dent))
    for _ in range(1000):  # off the object it recovers
        force, dent, _ = pressed(-1e-3, 0.0, law, dent, step)
    assert force == 0.0
    assert dent == pytest.approx(expected * math.exp(-0.1 / time), rel=2e-3)


def test_a_misplaced_object_is_one_that_stands_elsewhere():
    moved = dict(DYNAMOMETER, x=NOMINAL["object.x"] + 2e-3, y=NOMINAL["object.y"] - 1e-3)
    sizes = {"object_misplacement.x": 2e-3, "object_misplacement.y": -1e-3}
    assert np.array_equal(run(thing=moved)[1], run(sizes, DYNAMOMETER)[1])


def test_a_current_sensor_off_by_gain_and_offset():
    channels, states = run({"current_gain.error": 0.1, "current_offset.offset": 0.05})
    np.testing.assert_allclose(channels["current_A"], 1.1 * states[:, WINDING] + 0.05, atol=1e-12)


@pytest.mark.parametrize(("name", "of"), [("current_lag.time", "current"), ("force_lag.time", "")])
def test_lags_are_first_order(name, of):
    time = 8e-3
    lagged, states = run({name: time}, DYNAMOMETER, controller="continuous", tolerance=1e-6)
    if of:
        reported, real = lagged["current_A"], states[:, WINDING]
        assert np.array_equal(reported, states[:, SENSED])
    else:  # the hand does not feel it
        reported = lagged["force_N"]
        real = run(thing=DYNAMOMETER, controller="continuous", tolerance=1e-6)[0]["force_N"]
    expected, fade = np.zeros_like(real), math.exp(-1e-3 / time)
    slope = np.diff(real)  # exact for straight lines between the samples
    for k in range(1, real.size):
        steady = real[k] - slope[k - 1] * time / 1e-3
        before = real[k - 1] - slope[k - 1] * time / 1e-3
        expected[k] = steady + (expected[k - 1] - before) * fade
    np.testing.assert_allclose(reported, expected, atol=2e-3 * np.abs(real).max())


def test_a_delayed_command_moves_the_whole_run():
    base, late = run(thing=DYNAMOMETER)[0], run({"command_delay.time": 4e-3}, DYNAMOMETER)[0]
    assert np.array_equal(base["reference_rad"], late["reference_rad"])
    for name in ("position_rad", "current_A", "duty_1", "force_N"):
        np.testing.assert_allclose(late[name][4:], base[name][:-4], atol=1e-9)


@pytest.mark.parametrize("time", [2e-3, 2.4e-3])
def test_a_delayed_measurement_is_of_the_past(time):
    channels, states = run({"measurement_delay.time": time})
    shaft = states[:, SHAFT]
    clock = channels["time_s"]
    reported = [encoder(pack({}), angle) for angle in np.interp(clock[5:] - time, clock, shaft)]
    count = 2 * math.pi / 4096
    assert np.abs(channels["position_rad"][5:] - reported).max() < 1.01 * count
    assert np.mean(np.abs(channels["position_rad"][5:] - reported) < 1e-9) > 0.95
    assert not channels["position_rad"][:3].any()


def test_friction_steps_up_at_one_angle_of_one_joint():
    h = hand(friction_step__torque=0.03, friction_step__angle=0.6, friction_step__joint=2.0)
    drags = [friction_step.drag(h, 2, angle, 50.0, 10.0) for angle in (0.4, 0.6, 0.8)]
    assert drags == pytest.approx([0.0, 0.015, 0.03], abs=1e-6)
    assert friction_step.drag(h, 3, 0.8, 5.0, 10.0) == 0.0


def test_an_eccentric_pulley_conserves_power():
    h = hand(eccentric_pulley__share=0.1, eccentric_pulley__phase=0.7)
    angles = np.linspace(0.0, 10.0, 2001)
    wound, lever = np.array([eccentric_pulley.wound(h, a) for a in angles]).T
    assert wound[0] == 0.0
    np.testing.assert_allclose(np.gradient(wound, angles)[1:-1], lever[1:-1], rtol=1e-5)


def test_a_jammed_finger_stops_where_it_jams():
    _, free = run(points=scaled(PAPER, 1.0, 1.9))
    _, jammed = run({"jammed_finger.lost": 0.8}, points=scaled(PAPER, 1.0, 1.9))
    stop = 1.55 - 0.8 * (1.55 - 0.242)
    assert free[:, 2].max() > stop + 0.2
    assert jammed[:, 2].max() < stop + 0.1
    assert jammed[:, 0].max() > stop + 0.2


def test_all_effects_at_once_compiled_and_plain():
    sizes = {name: size.high if not size.amplitude else size.low for name, size in SIZES.items()}
    sizes |= {name: 0.05 for name, size in SIZES.items() if size.amplitude and size.low < 0}
    sizes |= {"object_misplacement.x": 1e-3, "object_misplacement.y": 1e-3}
    code = (
        "from benchmarks.truth import trace; "
        f"print(trace({{}}, [(0, 0), (0.01, 0.1)], duration=0.008, effects={sizes!r}, "
        "object={'shape': 'cylinder'})[1][-1].tolist())"
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
