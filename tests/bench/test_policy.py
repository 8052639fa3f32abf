"""The grip policy, tick by tick: what passes, what is limited, and when that ends."""

import itertools
from dataclasses import replace

import pytest

from hannes.bench.policy import GripMemory, GripSample, GripSettings, grip

SETTINGS = GripSettings()
TOUCH, FULL = 5.0, 9.0
SAMPLE = GripSample(1e-3, 0.0, 0.0, False, 0.0, 0.5, 0.0, 0.0, 0.0)


def closed(rigid, seconds=1.0, touched=True, **further):
    """Set points [rad] of a hand that closes at 15 rad/s, and touches something at TOUCH."""
    memory, found, position, now = GripMemory(), [], 0.0, False
    for tick in range(round(1000 * seconds)):
        wanted = min(15.0 * tick / 1000.0, FULL)
        now = touched and (now or position >= TOUCH)
        chance = rigid(tick / 1000.0) if callable(rigid) else rigid
        sample = SAMPLE._replace(
            wanted=wanted, position=position, touched=now, touch_position=TOUCH, rigid=chance
        )
        memory, position = grip(SETTINGS, memory, sample._replace(**further))
        found.append(position)
    return found


def limit(share):
    """Set point of a share of the travel beyond the touch."""
    return TOUCH + share * (FULL - TOUCH)


def test_an_empty_hand_follows_its_command_then_more_slowly_and_ends_hardly_moving():
    points = closed(0.0, touched=False, seconds=4.0)
    near = round(1000 * SETTINGS.approach_from / 15.0)
    assert points[near - 10] == pytest.approx(15.0 * (near - 10) / 1000.0)
    assert points[near + 200] == pytest.approx(
        SETTINGS.approach_from + 0.2 * SETTINGS.approach_speed, abs=0.01
    )
    there = near + round(
        1000 * (SETTINGS.free_to - SETTINGS.approach_from) / SETTINGS.approach_speed
    )
    assert points[there + 500] == pytest.approx(
        SETTINGS.free_to + 0.5 * SETTINGS.free_speed, abs=0.01
    )
    assert points[-1] == FULL


@pytest.mark.parametrize("place", [7.0, 8.8])
def test_a_hand_that_is_closed_already_goes_on_from_where_it_is(place):
    memory, points = GripMemory(), []
    for _ in range(50):
        memory, point = grip(SETTINGS, memory, SAMPLE._replace(wanted=FULL, position=place))
        points.append(point)
    most = SETTINGS.approach_speed if place < SETTINGS.free_to else SETTINGS.free_speed
    assert points == pytest.approx([place + 1e-3 * most * (k + 1) for k in range(50)])


def test_a_soft_object_gets_its_share_of_the_travel():
    points = closed(0.05)
    assert points[-1] == pytest.approx(TOUCH + SETTINGS.soft_share * (FULL - TOUCH))
    assert max(points) <= points[-1] + 0.05


def test_a_rigid_object_is_held_firmly():
    assert closed(0.99)[-1] == pytest.approx(FULL)


def test_a_moment_of_certainty_is_not_enough():
    blink = closed(lambda time: 0.99 if 0.40 < time < 0.42 else 0.6, seconds=0.7)
    assert blink[-1] < FULL - 1.0


def test_in_lasting_doubt_the_likelier_class_decides():
    assert closed(0.6, seconds=1.5)[-1] > FULL
    assert closed(0.3, seconds=1.5)[-1] == pytest.approx(limit(SETTINGS.probe_share))


def test_the_stiffness_of_an_object_pressed_on_in_doubt_decides():
    asked = {"seconds": 1.5, "rigid": 0.5}
    soft, rigid = (closed(stiffness=ratio, **asked) for ratio in (0.9, 1.1))
    assert soft[-1] == pytest.approx(limit(SETTINGS.soft_share))
    assert rigid[-1] > FULL - 0.01
    sure = closed(0.01, seconds=1.5, stiffness=1.1)  # never pressed on, so the traces say nothing
    assert sure[-1] == pytest.approx(limit(SETTINGS.soft_share))
    likely = closed(0.3, seconds=1.5, stiffness=1.1)  # the trees have it for soft, in doubt
    assert likely[-1] > FULL - 0.01
    soft_then = closed(lambda time: 0.3 if time < 0.7 else 0.01, seconds=1.5, stiffness=1.1)
    assert soft_then[-1] < FULL - 1.0
    firm = closed(0.99, seconds=1.5, stiffness=0.5)  # held by all of the command before
    assert firm[-1] == pytest.approx(FULL)


def test_a_stiffness_of_traces_without_the_press_decides_nothing():
    """Doubt that begins late presses on late: the traces are then other than what was learned."""
    since = TOUCH / 15.0
    early, late = (
        closed(lambda time, at=at: 0.3 if time > since + at else 0.05, seconds=1.5, stiffness=1.5)
        for at in (0.17, 0.35)
    )
    assert early[-1] > FULL - 0.01
    assert late[-1] == pytest.approx(limit(SETTINGS.probe_share))


def test_a_moment_of_another_opinion_decides_nothing():
    """The mean of a tenth of a second counts, before a firm hold and while it lasts."""
    late = TOUCH / 15.0 + SETTINGS.patience + 0.2
    blink = closed(lambda time: 0.9 if late < time < late + 0.02 else 0.2, seconds=1.5)
    assert max(blink) == pytest.approx(limit(SETTINGS.probe_share))
    kept = closed(lambda time: 0.1 if late < time < late + 0.05 else 0.9, seconds=1.5)
    assert min(kept[round(1000 * late) :]) > FULL


def test_the_later_a_firm_hold_comes_the_farther_it_presses():
    shares = [
        (closed(lambda time, at=at: 0.99 if time > at else 0.3, seconds=2.0)[-1] - TOUCH) / 4.0
        for at in (0.35, 0.55, 0.65, 1.5)
    ]
    assert shares[0] == pytest.approx(1.0, abs=0.01)
    assert shares[0] < shares[1] < shares[2] < shares[3] == pytest.approx(1.0 + SETTINGS.late_most)


def test_in_doubt_it_squeezes_slowly_on_and_goes_back_where_the_object_proves_soft():
    points = closed(lambda time: 0.3 if time < 1.5 else 0.01, seconds=2.5)
    begins = round(1000 * (TOUCH / 15.0 + SETTINGS.settle)) + 200
    assert points[begins] < points[begins + 20] < points[begins] + 0.03 * SETTINGS.probe_speed
    assert max(points) == pytest.approx(limit(SETTINGS.probe_share))
    assert points[-1] == pytest.approx(limit(SETTINGS.soft_share))
    steps = [b - a for a, b in itertools.pairwise(points[1500:])]
    assert min(steps) == pytest.approx(-1e-3 * SETTINGS.probe_speed)


def test_a_firm_hold_ends_where_the_object_proves_soft():
    points = closed(lambda time: 0.99 if time < 0.9 else 0.01, seconds=2.0)
    assert max(points) == pytest.approx(FULL)
    assert points[-1] == pytest.approx(TOUCH + SETTINGS.soft_share * (FULL - TOUCH))


def test_set_points_change_no_faster_than_the_command_and_the_limit():
    points = closed(lambda time: float(time > 0.6), seconds=1.0)
    steps = [b - a for a, b in itertools.pairwise(points)]
    assert max(map(abs, steps)) <= max(15.0, SETTINGS.speed) * 1e-3 + 1e-9


def test_opening_passes_at_once():
    memory, _ = grip(SETTINGS, GripMemory(set_point=7.0), SAMPLE._replace(
        wanted=8.0, position=7.0, touched=True, touch_position=TOUCH))  # fmt: skip
    _, point = grip(SETTINGS, memory, SAMPLE._replace(
        wanted=1.0, position=7.0, touched=True, touch_position=TOUCH))  # fmt: skip
    assert point == 1.0


@pytest.mark.parametrize("rigid", [0.0, 1.0])
def test_a_force_set_point_is_reached_on_a_spring(rigid):
    stiffness, memory, position = 8.0, GripMemory(), TOUCH  # N/rad
    for _ in range(4000):
        force = stiffness * max(position - TOUCH, 0.0)
        sample = SAMPLE._replace(
            wanted=FULL, position=position, touched=True, touch_position=TOUCH, rigid=rigid,
            force=force, force_high=force, force_wanted=10.0,
        )  # fmt: skip
        memory, position = grip(SETTINGS, memory, sample)
    assert stiffness * (position - TOUCH) == pytest.approx(10.0, rel=0.01)


def test_a_soft_object_under_force_control_counts_the_upper_end_of_its_band():
    spring = {"wanted": FULL, "touched": True, "touch_position": TOUCH, "force_wanted": 10.0}
    low = SAMPLE._replace(**spring, position=TOUCH, rigid=0.0, force=5.0, force_high=10.0)
    memory, _ = grip(SETTINGS, GripMemory(set_point=TOUCH), low)
    assert memory.offset == 0.0
    firm = replace(SETTINGS, dwell=0.0)
    memory, _ = grip(firm, GripMemory(set_point=TOUCH), low._replace(rigid=1.0))
    assert memory.offset > 0.0
