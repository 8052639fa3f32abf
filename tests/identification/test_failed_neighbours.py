"""A run that fails beside another is not a derivative of zero."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.few.cases import FULL
from benchmarks.truth import campaign as truth
from benchmarks.truth.protocol import RICH, Protocol
from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.linearisation import _near
from hannes.plants.hand import joint_deviations
from hannes.plants.hand.joint_deviations import parts
from hannes.plants.hand.plant import HandPlant
from hannes.plants.hand.recorded_experiment import experiment_of
from hannes.simulation.trajectory import Outcome

PART, PARAMETER = "index_mcp.spring_stiffness", "mcp.spring_preload"


@pytest.fixture(scope="module")
def recording():
    return next(iter(truth.make(Protocol((FULL,), RICH), 3).recordings.values()))


def slopes(recording):
    step = 0.01 * HandPlant().parameters[PARAMETER]
    return HandPlant().slopes({}, {PARAMETER: step}, recording, ("position",))


def failing(monkeypatch, rows):
    """Let these rows fail, counted over all calls."""
    seen, ended = [], joint_deviations.ended

    def some(counts):
        seen.append(0)
        fails = len(seen) - 1 in rows
        return (Outcome.NOT_FINITE if fails else ended(counts)[0], *ended(counts)[1:])

    monkeypatch.setattr(joint_deviations, "ended", some)


def test_a_part_or_a_side_that_fails_is_differenced_otherwise(recording, monkeypatch):
    right = slopes(recording)
    names = list(right)
    failing(monkeypatch, {1 + names.index(PART), len(names)})
    found = slopes(recording)
    for name in (PART, PARAMETER):
        one, other = right[name]["position"], found[name]["position"]
        assert np.any(one != other)
        assert one @ other > 0.7 * np.linalg.norm(one) * np.linalg.norm(other)


def test_where_no_neighbour_can_be_simulated_that_is_said(recording, monkeypatch):
    whole = 1 + len(parts(experiment_of(recording))) + 2  # the run, its parts, two sides of one
    failing(monkeypatch, {*range(1, whole), *range(whole + 1, 10 * whole)})
    with pytest.raises(ComputationFailed, match="what it does is not known"):
        slopes(recording)


def test_a_step_that_fails_is_taken_shorter_or_the_other_way():
    """A machine that cannot be simulated beyond 1; its bins are three times its value."""

    def vectors(group, rows, effects):
        return np.where(rows[:, :1] > 1.0, np.nan, 3.0 * rows[:, :1] + np.zeros((1, 2)))

    model = SimpleNamespace(
        vectors=vectors, changes=lambda group, x, rows, effects, here: vectors(0, rows, 0) - here
    )
    for at in (0.95, 0.9999):
        x = np.array([at])
        found = _near(model, None, 3.0 * x + np.zeros(2), x, x[np.newaxis] + 0.5, False)
        assert found == pytest.approx(1.5)
