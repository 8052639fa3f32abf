"""A closure on an object, even a soft one, is no empty closure: simulated hands, by the command."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hannes import simulate_many
from hannes.commands.cli import main
from hannes.dataset.empty_closure import empty_means
from hannes.dataset.sampling import emptied, sample_grasp
from hannes.dataset.spec import find, read_spec
from hannes.recognition import model_file, train_pressed
from hannes.recognition.known_hand import hand_numbers
from hannes.recognition.pressed import INPUTS
from hannes.recognition.train_pressed import Known, fitted
from hannes.simulation.sensors import CHANNELS, logged
from tests.bench.drawn_model import drawn_model

HANDS = 50  # that are learned from
SPONGE = {"object.stiffness": 150.0, "object.damping": 1.0, "object.radius": 0.012}  # 2 to 6 N


def spec():
    """The shipped set's hands and objects, without the effects that take long to compile."""
    text = find("held").read_text(encoding="utf-8")
    text = re.sub(r"effects = .*", "effects = []", text)
    text = re.sub(r'"(leader_slack|gear_load|floating_object|gravity)\..*', "", text)
    return read_spec(text)


def closed(grasps):
    """Recordings of grasps by the command of `empty-closure`."""
    pairs = [(each.hand, each.experiment) for each in grasps]
    ran = simulate_many(pairs, channels=CHANNELS, rtol=1e-3, workers=1, progress=False)
    return [logged(*pair, each.require()) for pair, each in zip(pairs, ran, strict=True)]


@pytest.fixture(scope="module")
def grasps():
    """Sampled grasps of the role that presses."""
    given = spec()
    return [sample_grasp(given, given.count - 1 - k) for k in range(HANDS + 6)]


@pytest.fixture(scope="module")
def model(grasps):
    """A model that learned from simulated hands, and knows nothing else."""
    hands = [
        empty_means(*(made[name] for name in ("current", "position", "reference")), 20, 160)
        for made in closed([emptied(spec(), each) for each in grasps[:HANDS]])
    ]
    hands = np.repeat(hands, 2, axis=0)  # two grasps each
    rows = np.random.default_rng(1).normal(0.0, 0.01, (2 * HANDS, INPUTS))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(train_pressed, "FEWEST_HANDS", HANDS)
        known = Known(rows, np.full(2 * HANDS, 8.6), np.zeros((2 * HANDS, 0)), hands)
        return replace(drawn_model(), pressed=fitted(known, 8.6, 0))


def holding(grasp, values):
    """The grasp's hand, closed by the command of `empty-closure` on its object of these values."""
    alone, target = emptied(spec(), grasp), grasp.experiment.object
    target = replace(target, values={**target.values, **values})
    return replace(alone, experiment=replace(alone.experiment, object=target))


def test_hands_that_were_not_learned_from_are_known_by_their_closures(grasps, model):
    for made in closed([emptied(spec(), each) for each in grasps[HANDS:]]):
        assert np.isfinite(hand_numbers(made, model)).all()


@pytest.mark.parametrize(
    "values", [SPONGE, {"object.stiffness": 500.0}, {"object.stiffness": 3e3}], ids=str
)
def test_a_closure_on_an_object_is_refused(grasps, model, values, tmp_path, capsys):
    model_file.write(tmp_path / "model.h5", model)
    for k, made in enumerate(closed([holding(each, values) for each in grasps[HANDS:]])):
        path = tmp_path / f"held-{k}.h5"
        made.write(path)
        assert made["force"].max() > 1.0
        asked = ["live", "socket://127.0.0.1:9", str(tmp_path / "model.h5")]
        assert main([*asked, "--empty", str(path)]) == 2
        said = capsys.readouterr().err
        assert f"{path.name}: the empty closure is unlike" in said and "something held" in said
