"""Kinds outside the catalogue: which are sealed, what their laws say, and that they show."""

import math

import numpy as np
import pytest

from benchmarks.naming_study import draw, plan
from benchmarks.truth import NOMINAL, trace
from benchmarks.truth.campaign import make
from benchmarks.truth.controller import encoder
from benchmarks.truth.effects import (
    OPENED,
    OUTSIDE,
    SEALED,
    SIZES,
    clock_error,
    damaged_tooth,
    encoder_eccentricity,
    error_dead_band,
    force_saturation,
    jammed_cart,
    limited_supply,
    notched_joint,
    saturating_motor,
    sheath_edge,
    soft_pad,
    stacked_wire,
    striking_thumb,
    thermal_derating,
)
from benchmarks.truth.protocol import DYNAMOMETER, PAPER
from benchmarks.truth.record import pack
from benchmarks.truth.state import ANGLE, MOTOR, MOTOR_SPEED, SHAFT, SIZE, SPEED
from benchmarks.truth.state import CURRENT as WINDING

NEW = (*OPENED[5:], *SEALED)
AMPLITUDES = [n for n, size in SIZES.items() if size.amplitude and n.partition(".")[0] in NEW]
FLOORS = 3.0


def hand(**sizes):
    """The kernels' record with effects, their names' dots as double underscores."""
    return pack({}, effects={name.replace("__", "."): x for name, x in sizes.items()})


def run(thing=None, **sizes):
    hidden = {name.replace("__", "."): x for name, x in sizes.items()}
    return trace({}, PAPER, object=thing, effects=hidden, duration=1.15)


@pytest.fixture(scope="module")
def usual():
    """Both runs of the poor protocol with nothing hidden, by the object."""
    return {thing is not None: run(thing) for thing in (None, DYNAMOMETER)}


@pytest.fixture(scope="module")
def noise_floors():
    """How far repeats of the poor protocol scatter, sensors included: by condition and channel."""
    made, found = make("poor", 3), {}
    for condition in ("void", "dynamometer"):
        runs = [made.recordings[n] for n, c in made.conditions.items() if c == condition]
        for channel in runs[0].keys() - {"time", "reference"}:
            spread = np.var([each[channel] for each in runs], axis=0, ddof=1)
            found[condition == "dynamometer", channel] = float(np.sqrt(spread.mean()))
    return found


def test_half_of_the_kinds_or_more_are_sealed():
    assert not set(OPENED) & set(SEALED)
    assert [each.__name__.rpartition(".")[2] for each in OUTSIDE] == [*OPENED, *SEALED]
    assert len(SEALED) >= len(OPENED) and len(OUTSIDE) >= 13


def test_no_case_of_development_hides_a_sealed_kind():
    for name, seed in plan.cases("development", False):
        kind = plan.NAMED[name]
        assert not set(draw.drawn(kind.what, kind.protocol, seed).effects) & set(SEALED)


def gaps(sizes, pressed, usual, noise_floors):
    """RMS of what the sizes change in one run, in noise floors, by channel."""
    changed, base = run(DYNAMOMETER if pressed else None, **sizes)[0], usual[pressed][0]
    columns = {each.rpartition("_")[0]: each for each in base}
    for at, channel in noise_floors:
        if at == pressed:
            off = changed[columns[channel]] - base[columns[channel]]
            yield np.sqrt(np.mean(off**2)) / noise_floors[at, channel]


@pytest.mark.parametrize("name", AMPLITUDES)
def test_at_its_end_a_kind_shows_above_three_floors_wherever_it_acts(name, usual, noise_floors):
    own = {n: s for n, s in SIZES.items() if n.startswith(f"{name.partition('.')[0]}.")}
    shapes = {n: s for n, s in own.items() if n != name}
    places = [{}, *({n: x} for n, s in shapes.items() for x in (s.low, s.high))]
    for end in {own[name].high, own[name].low if own[name].low < 0.0 else own[name].high}:
        for place in places:
            sizes = {name: end, **place}
            seen = [g for at in (False, True) for g in gaps(sizes, at, usual, noise_floors)]
            assert max(seen) > FLOORS, sizes


@pytest.mark.parametrize("name", AMPLITUDES)
def test_a_kind_of_size_0_changes_no_bit(name, usual):
    shapes = {n: s.low for n, s in SIZES.items() if n.startswith(f"{name.partition('.')[0]}.")}
    same = run(DYNAMOMETER, **{**shapes, name: 0.0})
    assert np.array_equal(same[1], usual[True][1])
    assert all(np.array_equal(same[0][each], x) for each, x in usual[True][0].items())


def work(force, places):
    """Of a force along a way."""
    return np.trapezoid([force(x) for x in places], places)


def test_a_notch_holds_from_both_sides_and_keeps_no_energy():
    h = hand(notched_joint__torque=0.05, notched_joint__angle=0.5, notched_joint__width=0.04)
    assert notched_joint.joint_torque(h, 2, 0.54, 0.0) == pytest.approx(0.05)
    assert notched_joint.joint_torque(h, 2, 0.46, 3.0) == pytest.approx(-0.05)
    assert notched_joint.joint_torque(h, 3, 0.54, 0.0) == 0.0
    places = np.linspace(0.1, 0.9, 801)
    assert abs(work(lambda q: notched_joint.joint_torque(h, 0, q, 1.0), places)) < 1e-9


def test_a_thumb_strikes_two_fingers_and_each_pushes_back():
    h, y = hand(striking_thumb__lost=1.5), np.zeros(SIZE)
    free = NOMINAL["fingers.mcp_upper"][4] + NOMINAL["fingers.mcp_upper"][0] - 1.5
    for f, angle in ((4, 0.6), (0, free - 0.59), (1, free - 0.58), (2, 1.5)):
        y[ANGLE + 2 * f] = angle
    pushes = [striking_thumb.push(h, f, y) for f in range(5)]
    assert pushes == pytest.approx([0.03, 0.06, 0.0, 0.0, 0.09])
    y[SPEED + 8] = -1e3  # it does not stick
    assert striking_thumb.push(h, 0, y) == 0.0
    y[SPEED + 8] = 1.0  # and what moves in loses energy
    assert striking_thumb.push(h, 0, y) > 0.03


def test_an_edge_takes_pull_on_the_way_in_and_holds_on_the_way_out():
    h = hand(sheath_edge__friction=0.5, sheath_edge__angle=0.3)
    assert sheath_edge.passed(h, 10.0, 0.29, 1.0) == 10.0
    assert sheath_edge.passed(h, 10.0, 0.5, 1.0) == pytest.approx(10.0 * math.exp(-0.1))
    assert sheath_edge.passed(h, 10.0, 0.5, -1.0) == pytest.approx(10.0 * math.exp(0.1))
    for speed in (-0.3, -1e-3, 0.0, 1e-3, 0.3):  # power of the cart's side less that of the finger
        assert (10.0 - sheath_edge.passed(h, 10.0, 0.6, speed)) * speed >= 0.0


def test_a_cart_jams_beyond_a_place():
    h = hand(jammed_cart__gradient=5000.0)
    assert jammed_cart.drag(h, 2e-3, 1.0) == 0.0
    assert jammed_cart.drag(h, 5e-3, 1.0) == pytest.approx(10.0)
    assert all(jammed_cart.drag(h, 5e-3, v) * v > 0.0 for v in (-0.1, -1e-3, 1e-3, 0.1))


def test_a_wire_on_its_own_turns_conserves_power():
    h = hand(stacked_wire__share=0.15, stacked_wire__from=2.5)
    angles = np.linspace(0.0, 6.0, 6001)
    more, lever = np.array([stacked_wire.further(h, a) for a in angles]).T
    assert not more[angles <= 2.5].any()
    assert lever[-1] == pytest.approx(0.15 * NOMINAL["gear.pulley_radius"])
    np.testing.assert_allclose(np.gradient(more, angles)[1:-1], lever[1:-1], atol=1e-8)


def test_a_damaged_tooth_rubs_once_in_a_turn_of_the_output_wheel():
    h, turn = hand(damaged_tooth__torque=5e-3, damaged_tooth__angle=1.0), 2.0 * math.pi
    angles = 19.0 * np.linspace(0.0, turn, 4001)
    torques = np.array([damaged_tooth.rotor_torque(h, a, 100.0, 0.0) for a in angles])
    assert angles[torques.argmax()] / 19.0 == pytest.approx(1.0, abs=2e-3)
    assert torques.max() == pytest.approx(5e-3, rel=1e-4)
    assert np.mean(torques > 1e-4) < 0.2
    again = damaged_tooth.rotor_torque(h, 19.0 * (1.0 + turn), -100.0, 0.0)
    assert again == pytest.approx(-5e-3)


def test_saturated_iron_pulls_less_the_more_current_there_is():
    h = hand(saturating_motor__inverse_current=0.5)
    assert saturating_motor.pulling(h, 1.0, 2.0) == pytest.approx(1.0 / math.sqrt(2.0))
    assert saturating_motor.pulling(h, -1e-3, -1e-3) == pytest.approx(-1e-3, rel=1e-6)
    currents = np.linspace(0.0, 50.0, 200)
    torques = [saturating_motor.pulling(h, 0.018 * i, i) for i in currents]
    assert (np.diff(torques) > 0.0).all() and torques[-1] < 0.018 / 0.5


def test_a_supply_falls_where_more_than_its_limit_is_drawn():
    channels, states = run(DYNAMOMETER, limited_supply__inverse_current=2.0)
    over = np.maximum(channels["duty_1"] * states[:, WINDING] - 0.5, 0.0)
    np.testing.assert_allclose(channels["supply_V"], 12.0 - 15.0 * over, atol=1e-9)
    assert channels["supply_V"].min() < 9.0
    assert limited_supply.bus_drop(hand(limited_supply__inverse_current=2.0), 1.0, 9.0) == 10.8


def test_a_warm_driver_asks_for_less_current(usual):
    channels, _ = run(DYNAMOMETER, thermal_derating__fall=8.0)
    heat = np.cumsum(channels["current_A"] ** 2) * 1e-3
    most = thermal_derating.limit(hand(thermal_derating__fall=8.0), 0.0) / (1.0 + 8.0 * heat)
    stalled = slice(550, 650)  # the inner controller follows a limit that falls slowly
    np.testing.assert_allclose(channels["current_A"][stalled], most[stalled], rtol=0.03)
    assert channels["force_N"].max() < 0.8 * usual[True][0]["force_N"].max()


def test_small_errors_of_position_are_none():
    h = hand(error_dead_band__width=0.1)
    used = [error_dead_band.used(h, 19.0 * e) / 19.0 for e in (-0.3, -0.1, 0.05, 0.2)]
    assert used == pytest.approx([-0.2, 0.0, 0.0, 0.1])


def test_a_magnet_off_its_shaft_is_read_by_the_encoder():
    sizes = {"encoder_eccentricity__error": 0.05, "encoder_eccentricity__phase": 0.6}
    h, (channels, states) = hand(**sizes), run(**sizes)
    assert encoder_eccentricity.seen(h, 0.0) == 0.0
    assert encoder_eccentricity.seen(h, 2.0) == pytest.approx(
        2.0 + 0.05 * (math.sin(2.6) - math.sin(0.6))
    )
    asked = [encoder(h, encoder_eccentricity.seen(h, a)) for a in states[:, SHAFT]]
    assert np.array_equal(channels["position_rad"], asked)


def test_a_saturated_force_sensor_leaves_the_hand_alone(usual):
    real, states = usual[True]
    channels, same = run(DYNAMOMETER, force_saturation__inverse_force=5e-3)
    assert np.array_equal(channels["current_A"], real["current_A"])
    assert np.array_equal(same[:, :WINDING], states[:, :WINDING])
    read = [force_saturation.seen(hand(force_saturation__inverse_force=5e-3), x) for x in (100, -1)]
    assert read == pytest.approx([100.0 / 1.5, -1.0 / 1.005])
    np.testing.assert_allclose(
        channels["force_N"], real["force_N"] / (1.0 + 5e-3 * real["force_N"]), rtol=1e-12
    )


def test_a_soft_pad_is_met_before_the_finger_and_carries_at_most_its_flat_force(usual):
    assert [soft_pad.push(x, 2e-3, 1000.0) for x in (-3e-3, -1e-3, 0.0, 1e-3)] == [
        0.0,
        1.0,
        2.0,
        2.0,
    ]
    pad = run(DYNAMOMETER, soft_pad__thickness=3e-3)[0]["force_N"]
    bare = usual[True][0]["force_N"]
    assert np.flatnonzero(pad > 0.0)[0] < np.flatnonzero(bare > 0.0)[0] - 10


@pytest.mark.parametrize("share", [-0.1, 0.1])
def test_a_second_of_a_slow_board_lasts_longer(share):
    assert clock_error.lasting(hand(clock_error__share=share)) == 1.0 + share
    channels, states = run(clock_error__share=share)
    turned = np.trapezoid(states[:600, MOTOR_SPEED], channels["time_s"][:600])
    assert states[599, MOTOR] == pytest.approx((1.0 + share) * turned, rel=2e-3)


@pytest.mark.parametrize("name", ["thermal_derating.fall", "clock_error.share"])
def test_what_acts_in_periods_needs_the_sampled_controller(name):
    with pytest.raises(ValueError, match=f"{name} needs the sampled controller"):
        trace({}, PAPER, effects={name: 0.1}, controller="continuous")
