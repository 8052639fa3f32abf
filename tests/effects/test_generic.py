"""Generic disturbances: what they are drawn as is what they do, and a hand.toml names them."""

from dataclasses import replace

import numpy as np
import pytest
from catalogued import EXPERIMENTS
from effect_contract import touch

from hannes.control.generic_loop_error import PLACES
from hannes.core.kernels.jit import plain
from hannes.plants.hand.plant import HandPlant
from hannes.plants.plant_file import load_model, plant_toml
from hannes.simulation.catalogue import descriptions, effects
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate

ALL = descriptions()


@pytest.mark.parametrize("name", ALL)
def test_a_description_is_of_the_hand_and_says_what_it_is(name):
    each = ALL[name]
    assert name.startswith("generic_") and name not in effects()
    assert HandPlant().accepts(each.effect) == ""
    assert "names no cause" in " ".join(each.effect.meaning.split()) and each.value in each.words
    assert each.ends[0] < each.ends[1]


@pytest.mark.parametrize("name", ALL)
def test_its_law_vanishes_at_off_and_is_finite(name):
    each = ALL[name]
    places = np.linspace(*each.ends, 9)
    off = [p.value if p.off is None else p.off for p in each.effect.fitted]
    at_off = each.at(places, off)
    assert np.ptp(at_off) == 0.0 and at_off[0] in (0.0, 1.0)
    most = [p.bounds[1] for p in each.effect.fitted]
    assert np.isfinite(each.at(places, most)).all()


@pytest.mark.parametrize("name", sorted(ALL.keys() - {"generic_easing", "generic_turn_friction"}))
def test_its_slopes_are_those_of_a_linear_law(name):
    each = ALL[name]
    rng, places = np.random.default_rng(3), np.linspace(*each.ends, 7)
    sizes = [0.5 * p.bounds[1] * rng.uniform() for p in each.effect.fitted]
    line = np.array(sizes) @ each.slopes(places, sizes)
    assert line == pytest.approx(each.at(places, sizes), rel=1e-6, abs=1e-9)


def test_the_kernel_does_what_is_drawn():
    """Of friction over speed: the law, with the sign of the motion."""
    each = ALL["generic_speed_friction"]
    (term,) = each.effect.terms
    sizes, ratio = [1e-3, -4e-4, 3e-4, 0.0, 2e-4], 19.0
    for speed in (-20.0, -3.0, 4.0, 25.0):
        made = plain(term.kernel)(speed * ratio, 5.0, ratio, *sizes)
        assert made == pytest.approx(np.sign(speed) * each.at(np.array([speed]), sizes)[0])


def test_an_encoder_off_its_centre_is_within_the_law_of_its_error():
    """Once a turn, at any phase: cosines over the travel leave less than a fifth of it."""
    each = ALL["generic_position_error"]
    places = np.linspace(*each.ends, 201)
    columns = each.slopes(places, [0.0] * len(each.effect.parameters))
    for phase in np.arange(0.0, 6.0, 0.5):
        wanted = np.sin(places + phase) - np.sin(phase)
        found = np.linalg.lstsq(columns.T, wanted, rcond=None)[0] @ columns
        assert np.std(found - wanted) < 0.2 * np.std(wanted)


def test_a_cart_that_jams_is_pushed_against_its_motion():
    each = ALL["generic_cart_friction"]
    (term,) = each.effect.terms
    sizes = [0.5, 0.5, 0.0, 0.0, 0.0]  # from nothing at rest to 1 N at the end
    assert plain(term.kernel)(10e-3, 1.0, 1e-3, *sizes) == pytest.approx(1.0)
    assert plain(term.kernel)(5e-3, -1.0, 1e-3, *sizes) == pytest.approx(-0.5)


def test_friction_over_the_motors_angle_is_against_its_motion():
    each = ALL["generic_angle_friction"]
    (term,) = each.effect.terms
    sizes = [1e-3, 4e-4, 0.0, -2e-4, 0.0, 0.0, 1e-4]
    for angle, sign in ((2.0, 1.0), (7.0, -1.0)):
        made = plain(term.kernel)(19.0 * angle, sign * 400.0, 5.0, 19.0, *sizes)
        assert made == pytest.approx(sign * each.at(np.array([angle]), sizes)[0])


def test_torque_over_current_is_that_of_the_law():
    each = ALL["generic_current_torque"]
    (term,) = each.effect.terms
    sizes = [1e-3, -2e-3, 5e-4, 1e-4, 0.0]
    assert plain(term.kernel)(-1.2, *sizes) == each.at(np.array([-1.2]), sizes)[0]


def test_what_pushes_a_phalanx_early_never_pulls_and_no_more_from_the_touch_on():
    each = ALL["generic_near_force"]
    there = np.array([-1.0, -4e-3, -2e-3, 0.0, 5e-3])
    assert each.at(there, [6.0, 0.0, 0.0, 0.0]) == pytest.approx([0.0, 0.0, 3.0, 6.0, 6.0])
    assert each.at(there, [-6.0, 12.0, 0.0, 0.0]) == pytest.approx([0.0, 0.0, 0.0, 6.0, 6.0])


def test_a_hand_that_is_pushed_early_touches_earlier():
    each = ALL["generic_near_force"].effect
    bare = Hand((each,))
    pushed = bare.with_values({each.full_name("c_1"): 5.0})
    without, run = (
        simulate(hand, EXPERIMENTS["soft ball"], rtol=1e-6, effects=(each,)).require()
        for hand in (bare, pushed)
    )
    assert touch(run) < touch(without) - 0.01


def test_the_position_loop_never_acts_against_the_error_it_sees():
    each = ALL["generic_loop_error"]
    (term,) = each.effect.terms
    rng, errors = np.random.default_rng(5), np.array([-0.3, -0.1, -6e-3, 1e-3, 0.02, 0.4])
    for _ in range(20):
        sizes = [rng.uniform(*p.bounds) for p in each.effect.parameters]
        assert (np.sign(errors) * (errors + each.at(errors, sizes)) >= 0.0).all()
        made = [plain(term.kernel)(19.0 * error, 19.0, *sizes) for error in errors]
        assert made == pytest.approx(19.0 * each.at(errors, sizes))


@pytest.mark.parametrize("controller", ["continuous", "sampled"])
def test_a_position_loop_that_takes_small_errors_for_none_rests_as_far_off(controller):
    each = ALL["generic_loop_error"].effect
    experiment = replace(EXPERIMENTS["void"], controller=controller)
    bare = Hand((each,))
    dead = bare.with_values({each.full_name(f"c_{k}"): -p for k, p in enumerate(PLACES, 1)})
    runs = [
        simulate(hand, experiment, rtol=1e-6, effects=(each,)).require() for hand in (bare, dead)
    ]
    without, there = (abs(run["reference"][-1] - run["position"][-1]) for run in runs)
    assert there - without == pytest.approx(PLACES[-1], rel=0.1)


def test_a_leader_that_earlier_runs_have_lengthened_is_slack_and_goes_on():
    each = ALL["generic_lengthening"].effect
    bare = Hand((each,))
    held = bare.with_values({each.full_name("per_charge"): 2e-3})
    after = held.with_values({each.full_name("charge"): 1.0})  # 2 mm
    runs = [
        simulate(hand, EXPERIMENTS["soft ball"], rtol=1e-6, effects=(each,)).require()
        for hand in (bare, held, after)
    ]
    touches = [touch(run) for run in runs]
    assert touches[0] < touches[1] < touches[2] - 0.01


def test_what_rubs_at_one_angle_of_each_turn_is_against_the_motion():
    each = ALL["generic_turn_friction"]
    (term,) = each.effect.terms
    sizes = [2e-3, 1.0, 0.2]
    for turn, sign in ((0.0, 1.0), (2.0 * np.pi, -1.0)):
        made = plain(term.kernel)(19.0 * (1.1 + turn), sign * 400.0, 5.0, 19.0, *sizes)
        assert made == pytest.approx(sign * each.at(np.array([1.1]), sizes)[0])


def test_a_hand_file_names_a_generic_disturbance(tmp_path):
    each = ALL["generic_joint_torque"]
    plant = HandPlant().with_effects(each.effect)
    plant = plant.with_values({each.effect.full_name("c_1"): 0.02})
    (tmp_path / "hand.toml").write_text(plant_toml(plant, HandPlant(), "hannes", tmp_path))
    read = load_model(str(tmp_path / "hand.toml"))
    assert read.parameters[each.effect.full_name("c_1")] == 0.02
    assert [e.name for e in read.effects] == ["generic_joint_torque"]
