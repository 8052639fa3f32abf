"""The catalogue: what each effect promises, at off and at the ends of its range."""

from dataclasses import replace

import numpy as np
import pytest
from catalogued import AMPLITUDES, CATALOGUE, EVERYTHING, EXPERIMENTS, RANGES, ledger, ran
from runs import grasp

from hannes.core.errors import BadInput
from hannes.simulation.experiment.experiment import Experiment, Target
from hannes.simulation.experiment.load import load
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate

SHIPPED = ("dynamometer", "void-closure", "soft-ball")

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


SOLVER_ERROR = 3e-6  # of a peak; so much runs differ by their steps


@pytest.mark.parametrize("name", AMPLITUDES)
def test_a_small_amplitude_does_little(name):
    """A thirtieth of the size leaves at most a sixth of the mark."""
    size = max(RANGES[name].low, RANGES[name].high / 100.0)
    # backlash is a free run of the motor at the start, in no channel to be seen later
    bare, large, small = (
        ran("dynamometer", **{name.replace(".", "__"): share * size})
        for share in (0.0, 1.0, 1 / 30)
    )
    for channel in ("current", "force", "position", "duty", "motor_current"):
        peak = np.abs(bare[channel]).max()
        whole, part = (np.abs(run[channel] - bare[channel]).mean() for run in (large, small))
        assert part <= whole / 6.0 + SOLVER_ERROR * peak, channel


# --- energy -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", AMPLITUDES)
def test_ledger_closes(name):
    found, bare = ledger(name), ledger()
    assert abs(found["residual"]) < 1e-4
    assert found["wire_friction"] >= 0.0 == bare["wire_friction"]


# --- sizes and cost ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", AMPLITUDES)
def test_shipped_experiments_run_at_the_ends_of_the_range(name):
    each = AMPLITUDES[name]
    for size in {RANGES[name].low, RANGES[name].high, *each.bounds} - {each.off}:
        hand = EVERYTHING.with_values({name: size})
        for shipped in SHIPPED:
            (variant,) = load(shipped)
            run = simulate(hand, variant.experiment, effects=EVERYTHING.effects).require()
            assert np.isfinite(run["current"]).all() and np.isfinite(run["force"]).all()


def with_all(share, experiment, **how):
    """A run with every effect at a share of the largest size it may physically have."""
    hand = EVERYTHING.with_values({name: share * RANGES[name].high for name in AMPLITUDES})
    return simulate(hand, experiment, effects=EVERYTHING.effects, **how).require()


@pytest.mark.parametrize("shipped", SHIPPED)
def test_the_whole_catalogue_keeps_the_structure_and_the_steps(shipped):
    (variant,) = load(shipped)
    bare = simulate(Hand(), variant.experiment).require()
    run = with_all(1e-3, variant.experiment)
    assert run.compiled.jacobian_kind == "structured"
    assert run.cost.evaluations < 1.5 * bare.cost.evaluations


def test_the_whole_catalogue_moves_the_same_by_another_method():
    experiment = Experiment("all", 0.5, grasp().reference, Target("cylinder"))
    mine, theirs = (
        with_all(0.1, experiment, method=method, rtol=1e-6) for method in ("Rodas", "Radau")
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
