"""Of the shapes that an unknown may have, the first that unfitted recordings do not oppose."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis.shape import shape
from hannes.identification.diagnosis.shape.likeliest import _best_of_each
from hannes.identification.diagnosis.tuning import SHAPE
from hannes.identification.shape_words import shape_sentence

CLOSES = {"torque": 0.9, "friction": 0.5, "lag": 0.5 * SHAPE.least_closed}


def fit(name, reduction):
    """A fit of a generic disturbance of that name, of a misfit that is 100 beyond noise."""
    description = SimpleNamespace(effect=SimpleNamespace(name=name), words=f"a {name}")
    base = SimpleNamespace(chi2=110.0, residual=np.zeros(10))
    return SimpleNamespace(description=description, reduction=reduction, base=base)


def test_each_disturbance_counts_by_its_best_fit():
    made = [fit("torque", 5.0), fit("friction", 8.0), fit("friction", 40.0), fit("torque", 50.0)]
    best = [(each.description.effect.name, each.reduction) for each in _best_of_each(made)]
    assert best == [("torque", 50.0), ("friction", 40.0)]


@pytest.mark.parametrize(
    ("opposed", "found"),
    [((), "torque"), (("torque",), "friction"), (("torque", "friction"), "")],
)
def test_shapes_that_recordings_oppose_are_passed_over(monkeypatch, opposed, found):
    likely = [fit("torque", 50.0), fit("friction", 40.0), fit("lag", 30.0)]
    table = chosen(monkeypatch, likely, lambda each: Held(each, opposed))
    assert table["name"] == found
    assert table.get("closes", 0.0) == CLOSES.get(found, 0.0)
    assert found or table["why_not"] == "a torque: it raises a gap"


@pytest.mark.parametrize(
    ("reduction", "could_show", "found"),
    [(95.0, False, "lag"), (60.0, False, ""), (95.0, True, "")],
)
def test_where_no_gap_could_fall_what_explains_nearly_all_is_drawn(
    monkeypatch, reduction, could_show, found
):
    changes = [SimpleNamespace(better=False, could_show=could_show)]
    likely = [fit("lag", reduction)]
    table = chosen(monkeypatch, likely, lambda each: Held(each, (), changes))
    assert table["name"] == found
    assert not found or table["explains"] == pytest.approx(0.95)
    assert found or "closes less than 10 %" in table["why_not"]


def test_what_unfitted_recordings_cannot_show_is_said_so():
    table = {"name": "generic_lag", "meaning": "a lag", "closes": 0.05, "explains": 0.95}
    table["shown"] = False
    assert "explains 95 % of the misfit" in shape_sentence(table)
    assert "by less than runs may differ by" in shape_sentence(table)
    assert "closes 40 % of the reducible gap" in shape_sentence(
        table | {"closes": 0.4, "shown": True}
    )


def chosen(monkeypatch, likely, held):
    """The table of the shape that is chosen of some fits."""
    monkeypatch.setattr(shape, "applicable", lambda plant: likely)
    monkeypatch.setattr(shape, "likeliest", lambda *given: likely)
    monkeypatch.setattr(shape, "_held", lambda found, each, stages: held(each))
    monkeypatch.setattr(shape, "_closed", lambda held: CLOSES[held.name])
    monkeypatch.setattr(
        shape, "_table", lambda each, factor: {"name": each.description.effect.name}
    )
    monkeypatch.setattr(shape, "_machine", lambda *given: None)
    given = SimpleNamespace(variance_factor=1.0), SimpleNamespace(plant=None)
    return shape.shape_of(*given, "", print).table


class Held:
    """Stages with a description that some recordings oppose."""

    def __init__(self, each, opposed, changes=()):
        self.name, self.opposed = each.description.effect.name, opposed
        self.changes = changes

    def change(self, one, other):
        """How the gap of unfitted recordings changes."""
        return self.changes

    def refusal(self, one, other):
        """Why it is not taken, or an empty string."""
        return "it raises a gap" if self.name in self.opposed else ""
