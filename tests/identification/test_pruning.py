"""Of an effect's sizes only those stay that the recordings ask for."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from sled import HARDENING, TURBULENCE, campaign

from hannes.commands.diagnose import diagnose
from hannes.core.effect import Term
from hannes.core.kernels.jit import kernel
from hannes.dynamics.wire_compliance import EFFECT
from hannes.identification.diagnosis import pruning
from hannes.identification.diagnosis.pruning import pruned
from hannes.identification.diagnosis.tuning import FIT, SEARCH

NAME = EFFECT.name


@kernel
def harder(cubic, position):
    """Of the spring [N]."""
    return -cubic * position**3


@kernel
def rougher(quadratic, speed):
    """Of the air [N]."""
    return -quadratic * speed * abs(speed)


STORM = replace(
    TURBULENCE,
    name="storm",
    parameters=(
        replace(HARDENING.parameters[0], name="cubic"),
        replace(TURBULENCE.parameters[0], name="quadratic"),
    ),
    terms=(Term(harder, ("force",)), Term(rougher, ("force",))),
)  # two sizes, of which one is hidden


def fit(monkeypatch, without, effect=EFFECT, active=(3, 4), linear=None):
    """A made-up fit of two sizes, at places 3 and 4; without: misfit by the places held at off.

    linear: by how much it rises by the linearisation, by place
    """
    names = [effect.full_name(each.name) for each in effect.amplitudes]
    space = SimpleNamespace(effects={effect.name: effect}, place=lambda n: 3 + names.index(n))

    def held(point, places, values, below):
        assert not values.any()  # off
        off = (*point.off, *places.tolist())
        chi2 = without[off]
        return (
            None
            if chi2 is None
            else SimpleNamespace(chi2=chi2, off=off, space=space, active=active)
        )

    monkeypatch.setattr(pruning, "held_at", held)
    monkeypatch.setattr(pruning, "wald", lambda point, places: (linear or {}).get(places[0], 0.0))
    return SimpleNamespace(chi2=100.0, off=(), space=space, active=active)


def test_what_lowers_the_misfit_by_too_little_stays_at_off(monkeypatch):
    point = fit(monkeypatch, {(3,): 150.0, (4,): 100.0 + 0.9 * SEARCH.parameter_price})
    assert pruned(point, [NAME], 1.0).off == (4,)


def test_what_is_asked_for_stays(monkeypatch):
    point = fit(monkeypatch, {(3,): 150.0, (4,): 100.0 + 1.1 * SEARCH.parameter_price})
    assert pruned(point, [NAME], 1.0) is point
    assert pruned(point, [NAME], 1.3).off == (4,)  # in the noise that is there it is not


def test_a_size_that_is_surely_missed_is_tried_without_only_where_another_may_go(monkeypatch):
    """By the linearisation alone: where both could go, both stay."""
    sure = {3: 1.1 * SEARCH.surely_missed}
    stays = {(4,): 100.0 + 1.1 * SEARCH.parameter_price}  # nothing is known without the first
    assert pruned(point := fit(monkeypatch, stays, linear=sure), [NAME], 1.0) is point
    assert pruned(fit(monkeypatch, {(3,): 150.0, (4,): 101.0}, linear=sure), [NAME], 1.0).off == (
        4,
    )
    either = fit(monkeypatch, {(3,): 102.0, (4,): 101.0}, linear=sure)
    assert pruned(either, [NAME], 1.0) is either
    both = fit(monkeypatch, {}, linear=sure | {4: 1.1 * SEARCH.surely_missed})
    assert pruned(both, [NAME], 1.0) is both


def test_where_either_could_go_both_stay(monkeypatch):
    point = fit(monkeypatch, {(3,): 101.0 + 0.9 * FIT.missed_more, (4,): 101.0})
    assert pruned(point, [NAME], 1.0) is point


@pytest.mark.parametrize("lost", [3, 4])
def test_a_size_without_which_nothing_can_be_simulated_stays(monkeypatch, lost):
    point = fit(monkeypatch, {(3,): 101.0, (4,): 101.0} | {(lost,): None})
    assert pruned(point, [NAME], 1.0).off == (7 - lost,)


def test_the_last_size_stays(monkeypatch):
    point = fit(monkeypatch, {(3,): 150.0, (4,): 100.0, (4, 3): 100.0})
    assert pruned(point, [NAME], 1.0).off == (4,)


def test_rivals_that_were_not_fitted_are_left_alone(monkeypatch):
    point = fit(monkeypatch, {(3,): 150.0, (4,): 100.0}, active=())
    assert pruned(point, [NAME], 1.0) is point


def test_the_hand_with_the_effect_has_it_where_its_first_size_stays_at_off():
    result = diagnose(campaign(1, ((TURBULENCE, 2.0),), {"storm": STORM}), progress=False)
    assert result.verdict.effects == ["storm"]
    (name,) = result.verdict.parameters
    assert name == "storm.quadratic"
    assert [each.name for each in result.plant.effects] == ["storm"]
    assert result.plant.parameters["storm.cubic"] == 0.0
    assert result.plant.parameters["storm.quadratic"] == pytest.approx(2.0, rel=0.1)
