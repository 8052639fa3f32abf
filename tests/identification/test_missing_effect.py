"""Whether what a calibration leaves looks like an effect that the model lacks."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.core.parameter import Parameter
from hannes.identification.calibration import missing_effect as module
from hannes.identification.calibration.missing_effect import (
    MissingEffect,
    _both,
    _chance,
    _deviations,
    _directions,
    _step,
    missing_effect,
)
from hannes.simulation.catalogue import effects
from tests.oven import Oven

SIZE = 100
RNG = np.random.default_rng(5)
ASKED, UNCERTAIN, EFFECT = (RNG.standard_normal((k, SIZE)) for k in (2, 3, 4))

WHITE = np.linalg.cholesky(np.linalg.inv(np.eye(SIZE) + UNCERTAIN.T @ UNCERTAIN)).T


def state(left, prior=0.1):
    """A fit with two parameters asked for, noise of 1, and these residuals at its end."""
    return SimpleNamespace(
        together=lambda rows: np.atleast_2d(np.concatenate(rows, axis=-1)) @ WHITE.T,
        whitened_residual=lambda residuals: WHITE @ residuals[0],
        jacobian=lambda: ASKED @ WHITE.T,
        scales=SimpleNamespace(prior=np.full(2, prior)),
        x=np.zeros(2),
        residuals=[left],
    )


def test_deviations_are_standard_normal_where_nothing_is_missing():
    sizes = []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        left = rng.standard_normal(SIZE) + rng.standard_normal(3) @ UNCERTAIN
        sizes.append(_deviations(state(left), [EFFECT]))
    assert np.mean(sizes) == pytest.approx(0.0, abs=0.1)
    assert np.std(sizes) == pytest.approx(1.0, abs=0.08)


def test_a_missing_effect_stands_out_with_its_sign():
    left = RNG.standard_normal(SIZE) - 0.5 * EFFECT[2]  # simulated minus measured
    sizes = _deviations(state(left), [EFFECT])
    assert np.argmax(np.abs(sizes)) == 2 and sizes[2] > 3.0


def test_what_the_parameters_can_do_is_no_effect():
    sizes = _deviations(state(RNG.standard_normal(SIZE)), [np.vstack([ASKED[0], EFFECT[0]])])
    assert abs(sizes[0]) < 1.0


def test_an_effect_of_one_sign_is_tested_one_way():
    slack = Parameter("length", 0.0, "m", (0.0, 0.01), "of the leader", off=0.0)
    back = Parameter("share", 1.0, "1", (0.0, 1.0), "of what is left", off=1.0)
    assert not _both(slack) and _step(slack) == pytest.approx(0.01 / 60.0)
    assert not _both(back) and _step(back) == pytest.approx(1.0 - 1.0 / 60.0)
    assert _both(Parameter("bias", 0.0, "1", (-1.0, 1.0), "either way", off=0.0))
    assert _chance(-5.0, both=False) > 0.99 and _chance(-5.0, both=True) < 1e-5


def test_every_amplitude_of_the_catalogue_has_a_direction():
    for effect in effects().values():
        names = {effect.full_name(each.name) for each in effect.amplitudes}
        moved = [names & set(each.values) for each in _directions(effect)]
        assert all(len(each) == 1 for each in moved) and set().union(*moved) == names


def test_a_plant_that_cannot_run_alike_is_not_tested():
    found = SimpleNamespace(model=SimpleNamespace(plant=Oven()))
    assert missing_effect(found, []) == MissingEffect() and MissingEffect().sentence == ""


def test_the_sentence_says_what_was_found_and_that_it_may_be_something_like_it():
    likely = MissingEffect("leader slack", 6.0, 1e-6, 20)
    assert likely.likely and "looks like leader slack" in likely.sentence
    assert "something like it" in likely.sentence
    none = MissingEffect("leader slack", 1.0, 0.9, 20)
    assert not none.likely and none.sentence.startswith("Of 20 effects")
    assert module.CALIBRATION.missing_p_value == 0.02
