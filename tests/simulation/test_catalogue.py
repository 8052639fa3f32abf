"""The catalogue: what each effect promises, at off and at the ends of its range."""

import functools
import re
from dataclasses import replace

import numpy as np
import pytest
from catalogued import AMPLITUDES, CATALOGUE, EVERYTHING, EXPERIMENTS, TABLE, ran
from runs import grasp

from benchmarks.truth import effects as second
from hannes.core.errors import BadInput
from hannes.simulation.energy_balance import energy_ledger
from hannes.simulation.experiment.experiment import Experiment, Target
from hannes.simulation.experiment.load import load
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate

SHIPPED = ("dynamometer", "void-closure", "soft-ball")

# --- what is declared -------------------------------------------------------------------------


def test_the_catalogue_is_the_agreed_one():
    whole = {each.__name__.rpartition(".")[2] for each in second.CATALOGUE}
    assert set(CATALOGUE) == whole and len(CATALOGUE) == 22


@pytest.mark.parametrize("name", TABLE)
def test_parameters_are_the_agreed_ones(name):
    star, unit, low, high, default = TABLE[name]
    effect, _, own = name.partition(".")
    each = next(p for p in CATALOGUE[effect].parameters if p.name == own)
    assert each.unit == unit
    assert each.bounds[0] <= low and high <= each.bounds[1]
    assert (each.off is None) == (star == "*")
    assert each.value == (default if star else 0.0)


def test_no_parameter_is_left_out_of_the_table():
    declared = {e.full_name(p.name) for e in CATALOGUE.values() for p in e.parameters}
    assert declared == set(TABLE)


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=CATALOGUE)
def test_texts_fit_a_terminal(effect):
    assert max(map(len, str(effect).splitlines())) <= 78
    assert re.search(r"\(1[4-9]\d\d\)|\(20\d\d\)|paper", effect.source)


# --- off ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CATALOGUE)
def test_at_off_an_effect_is_left_out(name):
    dressed = Hand([name])
    assert dressed.compiled() is Hand().compiled()
    assert dressed.vector("cylinder").tobytes() == Hand().vector("cylinder").tobytes()


def test_at_off_the_whole_catalogue_changes_nothing_even_where_it_is_compiled_in():
    bare = simulate(Hand(), grasp(), rtol=1e-7).require()
    dressed = simulate(EVERYTHING, grasp(), rtol=1e-7, effects=EVERYTHING.effects).require()
    for name in ("current", "force", "sensor", "position", "leader_tension", "duty", "supply"):
        assert np.abs(bare[name] - dressed[name]).max() <= 2e-5 * max(np.ptp(bare[name]), 1e-9)


GRAIN = 3e-6  # of a peak; so much runs differ by their steps


@pytest.mark.parametrize("name", AMPLITUDES)
def test_a_small_amplitude_does_little(name):
    """A thirtieth of the size leaves at most a sixth of the mark."""
    size = max(TABLE[name][2], TABLE[name][3] / 100.0)
    # backlash is a free run of the motor at the start, in no channel to be seen later
    bare, large, small = (
        ran("dynamometer", **{name.replace(".", "__"): share * size})
        for share in (0.0, 1.0, 1 / 30)
    )
    for channel in ("current", "force", "position", "duty", "motor_current"):
        peak = np.abs(bare[channel]).max()
        whole, part = (np.abs(run[channel] - bare[channel]).mean() for run in (large, small))
        assert part <= whole / 6.0 + GRAIN * peak, channel


# --- energy -------------------------------------------------------------------------------------

# Entry of the ledger that an effect makes larger.
LOSSES = {
    "capstan.friction": "wire_friction",
    "gear_load.coefficient": "gear_friction",
    "winding_heating.rise": "copper",
    "spring_hysteresis.share": "spring",
    "viscoelastic_object.share": "contact_normal",
    "hunt_crossley.dissipation": "contact_normal",
}


@functools.cache
def ledger(name, size):
    hand = EVERYTHING.with_values({name: size} if name else {})
    run = simulate(hand, grasp(sampling=20_000.0), rtol=1e-6, effects=EVERYTHING.effects)
    return energy_ledger(run.require())


@pytest.mark.parametrize("name", AMPLITUDES)
def test_ledger_closes(name):
    found, bare = ledger(name, 0.5 * TABLE[name][3]), ledger("", 0.0)
    assert abs(found["residual"]) < 1e-4
    assert found["wire_friction"] >= 0.0 == bare["wire_friction"]
    if name in LOSSES:
        assert found[LOSSES[name]] > bare[LOSSES[name]] + 1e-4 * bare["electrical"]
    if name == "torque_ripple.amplitude":  # gives back what it takes
        assert 0.0 != abs(found["motor_torque"]) < 1e-3 * found["electrical"]


# --- sizes and cost ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", AMPLITUDES)
def test_shipped_experiments_run_at_the_ends_of_the_range(name):
    each = AMPLITUDES[name]
    for size in {TABLE[name][2], TABLE[name][3], *each.bounds} - {each.off}:
        hand = EVERYTHING.with_values({name: size})
        for shipped in SHIPPED:
            (variant,) = load(shipped)
            run = simulate(hand, variant.experiment, effects=EVERYTHING.effects).require()
            assert np.isfinite(run["current"]).all() and np.isfinite(run["force"]).all()


def whole_catalogue(share):
    """Every effect at a share of the largest size it may physically have."""
    return EVERYTHING.with_values({name: share * TABLE[name][3] for name in AMPLITUDES})


@pytest.mark.parametrize("shipped", SHIPPED)
def test_the_whole_catalogue_keeps_the_structure_and_the_steps(shipped):
    (variant,) = load(shipped)
    bare = simulate(Hand(), variant.experiment).require()
    run = simulate(whole_catalogue(1e-3), variant.experiment).require()
    assert run.compiled.jacobian_kind == "structured"
    assert run.cost.evaluations < 1.5 * bare.cost.evaluations


def test_the_whole_catalogue_moves_the_same_by_another_method():
    experiment = Experiment("all", 0.5, grasp().reference, Target("cylinder"))
    mine, theirs = (
        simulate(whole_catalogue(0.1), experiment, method=method, rtol=1e-6).require()
        for method in ("Rodas", "Radau")
    )
    for name in ("current", "force", "position"):
        assert np.abs(mine[name] - theirs[name]).max() < 1e-3 * np.ptp(theirs[name])


def test_delayed_readings_are_the_same_by_another_method():
    hand = EVERYTHING.with_values({"measurement_delay.time": 2.3e-3})
    short = replace(EXPERIMENTS["sampled"], duration=0.1)
    mine, theirs = (
        simulate(hand, short, method=method, rtol=1e-6, effects=EVERYTHING.effects).require()
        for method in ("Rodas", "LSODA")
    )
    for name in ("current", "position", "duty"):
        assert np.abs(mine[name] - theirs[name]).max() < 1e-3 * np.ptp(theirs[name])


def test_two_effects_of_one_name_are_refused():
    """Else both are compiled in and share their parameters: twice the physics."""
    one = CATALOGUE["capstan"]
    with pytest.raises(BadInput, match='two effects have the name "capstan"'):
        Hand([one, replace(one, meaning="another")])
    assert Hand([one]).with_effects(one).effects == (one,)
