"""Whether a law is named although a generic disturbance fits about as well."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from hannes.identification.diagnosis import shape_rival
from hannes.identification.diagnosis.decision import decide
from hannes.identification.diagnosis.score_test import screened
from hannes.identification.diagnosis.trials import Trial
from hannes.identification.diagnosis.tuning import SEARCH


def test_a_law_that_fits_better_stands_against_a_free_shape(investigated, monkeypatch):
    best, masks = investigated.trials[0], ([0b011] * 2, [0b100] * 2)
    much = 0.2 * best.delta_chi2
    rows = {  # by how much the shape fits worse, its numbers paid or not; its gain beside the law;
        "better": (2.0, 2.0, 0.0, 0.0),  # and what of the law's work it can do
        "better but for its numbers": (2.0, 0.5, 0.0, 0.0),
        "hardly better": (0.5, 2.0, 0.0, 0.5),
        "more beside": (2.0, 2.0, much, 0.0),
        "nested": (0.0, 0.5, 0.0, 0.9),
        "nested, too dear": (0.0, -0.1, 0.0, 0.9),
        "nested, and more beside": (0.0, 0.5, much, 0.9),
    }
    monkeypatch.setattr(
        shape_rival, "_shapes", lambda at: [SimpleNamespace(effect="any_torque", places=range(9))]
    )
    kinds = {}
    for name, (worse, priced, beside, follows) in rows.items():
        chi2 = best.point.chi2 + worse * SEARCH.rival * investigated.variance_factor
        rival = Trial(
            ("any_torque",), SimpleNamespace(chi2=chi2), best.delta_chi2 - priced * SEARCH.rival
        )
        monkeypatch.setattr(shape_rival, "left_beside", lambda found, shapes, size=beside: size)
        monkeypatch.setattr(shape_rival, "followed", lambda trial, shape, share=follows: share)
        kinds[name] = decide(replace(investigated, generic=rival), *masks).kind
    named = [name for name, kind in kinds.items() if kind == "named"]
    assert named == ["better", "nested"]
    assert set(kinds.values()) == {"named", "unknown"}


def test_what_is_nested_is_one_large_effect_of_fewer_numbers(investigated, monkeypatch):
    best = replace(investigated.trials[0], delta_chi2=SEARCH.nested_limit * SEARCH.name_limit + 1.0)
    for name, value in (("left_beside", 0.0), ("followed", 0.9)):
        monkeypatch.setattr(shape_rival, name, lambda *asked, size=value: size)

    def stands(law=best, shape="any_torque", numbers=9, priced=1.0):
        known = SimpleNamespace(effect=shape, places=range(numbers))
        monkeypatch.setattr(shape_rival, "_shapes", lambda at: [known])
        rival = Trial(("any_torque",), law.point, law.delta_chi2 - priced)
        return shape_rival.stands_against(investigated, law, rival)

    assert stands()
    assert not stands(law=replace(best, delta_chi2=best.delta_chi2 - 2.0))  # too small
    assert not stands(law=replace(best, effects=(*best.effects, *best.effects)))  # two laws
    assert not stands(numbers=1)  # no fewer numbers
    assert not stands(shape="any_easing")  # another shape's work
    assert not stands(priced=-0.1)


def test_a_shape_follows_a_law_that_is_a_case_of_it(investigated):
    """An effect's own signature follows all of it; what lies across it follows nothing."""
    best = investigated.trials[0]
    [own] = screened(best.point, best.effects)
    assert shape_rival.followed(best, own) > 0.95
    white = np.random.default_rng(0).standard_normal(own.signature.shape)
    assert shape_rival.followed(best, replace(own, signature=white)) < 0.2
