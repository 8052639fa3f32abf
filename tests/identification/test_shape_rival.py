"""Whether a law is named although a generic disturbance fits about as well."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis import shape_rival, single_effects
from hannes.identification.diagnosis.decision import decide
from hannes.identification.diagnosis.score_test import Guess
from hannes.identification.diagnosis.trials import Trial
from hannes.identification.diagnosis.tuning import SEARCH

SHAPE = "any_torque"
LARGE = SEARCH.nested_limit * SEARCH.name_limit


def disturbance(law, factor, worse=0.0, priced=0.0, numbers=9):
    """A generic disturbance that fits worse by so much, and gains less when numbers are paid."""
    space = SimpleNamespace(of=lambda name: np.arange(numbers))
    point = SimpleNamespace(chi2=law.point.chi2 + worse * factor, space=space)
    return Trial((SHAPE,), point, law.delta_chi2 - priced)


def test_a_law_that_fits_better_stands_against_a_free_shape(investigated, monkeypatch):
    best, masks = investigated.trials[0], ([0b011] * 2, [0b100] * 2)
    much, rival = 0.2 * best.delta_chi2, SEARCH.rival
    rows = {  # by how much the shape fits worse, its numbers paid or not; its gain beside the law
        "better": (2.0, 2.0, 0.0),
        "as well, by more numbers": (0.0, 0.5, 0.0),
        "worse, by more than chance": (-2.5, -2.0, 0.0),
        "more beside": (2.0, 2.0, much),
        "as well, and more beside": (0.0, 0.5, 2.0 * rival),
    }
    monkeypatch.setattr(shape_rival, "_shapes", lambda at: [])
    kinds = {}
    for name, (worse, priced, beside) in rows.items():
        factor = investigated.variance_factor
        generic = disturbance(best, factor, worse * rival, priced * rival)
        monkeypatch.setattr(shape_rival, "left_beside", lambda found, shapes, size=beside: size)
        kinds[name] = decide(replace(investigated, generic=generic), *masks).kind
    named = [name for name, kind in kinds.items() if kind == "named"]
    assert named == ["better", "as well, by more numbers"]
    assert set(kinds.values()) == {"named", "unknown"}


def test_what_fits_as_well_by_chance_is_one_effect_of_fewer_numbers(investigated, monkeypatch):
    large = replace(investigated.trials[0], delta_chi2=LARGE + 1.0)
    monkeypatch.setattr(shape_rival, "_shapes", lambda at: [])
    monkeypatch.setattr(shape_rival, "left_beside", lambda found, shapes: 0.0)

    def stands(law=large, **shape):
        generic = disturbance(law, investigated.variance_factor, **shape)
        return shape_rival.stands_against(investigated, law, generic)

    small = replace(large, delta_chi2=LARGE - 1.0)
    assert stands() and stands(worse=-5.0)
    assert not stands(law=small) and stands(law=small, worse=0.1)  # a small one must fit better
    assert not stands(law=replace(large, effects=(*large.effects, *large.effects)))
    assert not stands(numbers=1)  # no fewer numbers
    assert not stands(worse=-30.0)  # more than eight numbers gain by chance


@pytest.mark.parametrize(("beside", "doubtless"), [(5.0, True), (12.0, False)])
def test_a_shape_that_does_little_beside_a_law_raises_no_doubt(investigated, beside, doubtless):
    large = replace(investigated.trials[0], delta_chi2=LARGE + 1.0)
    guess = Guess(SHAPE, beside, np.arange(9), np.zeros(9), np.zeros((9, 1)))
    assert shape_rival.raises_no_doubt(large, guess) is doubtless
    assert not shape_rival.raises_no_doubt(replace(large, delta_chi2=30.0), guess)


def test_of_disturbances_that_fit_equally_well_the_one_of_fewest_numbers_is_asked(investigated):
    best = investigated.trials[0]
    made = [
        disturbance(best, 1.0, numbers=numbers, priced=priced)
        for numbers, priced in ((9, 0.0), (1, 0.9 * SEARCH.rival), (2, 1.1 * SEARCH.rival))
    ]
    assert single_effects._most_doubtful(made) is made[1]
    assert single_effects._most_doubtful([]) is None
