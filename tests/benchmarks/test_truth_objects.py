"""The ten objects: fixed beforehand, grasped by the truth, whose prisms are the library's."""

import numpy as np
import pytest

from benchmarks.truth import simulate
from benchmarks.truth.box import nearest, outside
from benchmarks.truth.objects import evaluation, grasp, things
from benchmarks.truth.protocol import PAPER
from hannes.report.paper.published import TABLE_3
from hannes.simulation.batch.simulate_many import simulate_many
from hannes.simulation.experiment.experiment import Experiment, Reference, Target
from hannes.simulation.hand.hand import Hand

BORDER = 5500.0  # N/m


def test_they_are_the_papers_and_some_lie_near_the_border():
    found = things()
    assert {each.name for each in found} == set(TABLE_3)
    rigid = {each.name for each in found if each.label == "rigid"}
    assert rigid == {"Hand dynamometer", "Aluminium block", "Ultem block", "Crutch handle"}
    for each in found:
        assert (each.values["stiffness"] > BORDER) == (each.label == "rigid")
    near = [each for each in found if 0.5 < each.values["stiffness"] / BORDER < 2.0]
    assert len(near) >= 2
    assert evaluation(found).count("[[object]]") == 10


@pytest.mark.parametrize("name", ["Sponge", "Crutch handle"])
def test_a_grasp_is_the_same_for_its_seed_and_does_not_name_the_object(name):
    (thing,) = [each for each in things() if each.name == name]
    first, again, other = (grasp(thing, (1, 2, n)) for n in (0, 0, 1))
    assert first == again and first != other
    assert first["force"][:50].max() < 2.0 < 20.0 < first["force"].max()
    assert "object" not in first.experiment and "N/m" not in first.experiment


@pytest.mark.parametrize("stiffness", [38300.0, 900.0])
def test_prisms_of_both_implementations_agree(stiffness):
    own = {"half_x": 0.022, "half_y": 0.016, "radius": 0.008, "stiffness": stiffness}
    place = dict(zip("xyz", (0.014, -0.047, 0.0), strict=True))
    thing = {"shape": "prism", **own, "position": tuple(place.values())}
    true = simulate({}, PAPER, object=thing, duration=1.15, controller="continuous")
    target = Target("prism", {f"object.{name}": x for name, x in (own | place).items()})
    experiment = Experiment("prism", 1.15, Reference(np.array(PAPER).T), target)
    (mine,) = simulate_many([(Hand(), experiment)], rtol=1e-5, workers=1)
    for name, theirs in (
        ("current", "current_A"),
        ("position", "position_rad"),
        ("force", "force_N"),
    ):
        off = np.abs(mine[name] - true[theirs])
        assert np.sqrt(np.mean(off**2)) < 2e-3 * np.ptp(true[theirs])


def test_the_nearest_place_of_a_rod_is_nearest():
    rng = np.random.default_rng(3)
    for _ in range(50):
        half = rng.uniform(5e-3, 20e-3, 2)
        start, along = rng.uniform(-60e-3, 60e-3, 2), rng.uniform(-50e-3, 50e-3, 2)
        tried = [start + s * along for s in np.linspace(0.0, 1.0, 2001)]
        least = min(outside(*point, *half)[0] for point in tried)
        if least > 2e-3:
            _, gap, x, y = nearest(*start, *along, *half)
            assert gap == pytest.approx(least, abs=1.5e-4)  # the blend's width
            assert np.hypot(x, y) == pytest.approx(1.0)
