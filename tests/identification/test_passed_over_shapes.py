"""Of the shapes that an unknown may have, the first that unfitted recordings do not oppose."""

from types import SimpleNamespace

import pytest

from hannes.identification.diagnosis.shape import shape
from hannes.identification.diagnosis.shape.likeliest import _best_of_each
from hannes.identification.diagnosis.tuning import SHAPE

CLOSES = {"torque": 0.9, "friction": 0.5, "lag": 0.5 * SHAPE.least_closed}


def fit(name, reduction):
    """A fit of a generic disturbance of that name."""
    description = SimpleNamespace(effect=SimpleNamespace(name=name), words=f"a {name}")
    return SimpleNamespace(description=description, reduction=reduction)


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
    monkeypatch.setattr(shape, "applicable", lambda plant: likely)
    monkeypatch.setattr(shape, "likeliest", lambda *given: likely)
    monkeypatch.setattr(shape, "_held", lambda found, each, stages: Held(each, opposed))
    monkeypatch.setattr(shape, "_closed", lambda held: CLOSES[held.name])
    monkeypatch.setattr(
        shape, "_table", lambda each, factor: {"name": each.description.effect.name}
    )
    monkeypatch.setattr(shape, "_machine", lambda *given: None)
    given = SimpleNamespace(variance_factor=1.0), SimpleNamespace(plant=None)
    table = shape.shape_of(*given, "", print).table
    assert table["name"] == found
    assert table.get("closes", 0.0) == CLOSES.get(found, 0.0)
    assert found or table["why_not"] == "a torque: it raises a gap"


class Held:
    """Stages with a description that some recordings oppose."""

    def __init__(self, each, opposed):
        self.name, self.opposed = each.description.effect.name, opposed

    def refusal(self, one, other):
        """Why it is not taken, or an empty string."""
        return "it raises a gap" if self.name in self.opposed else ""
