"""A small model, and grasps on a simulated board, for the tests of the bench."""

from dataclasses import replace

import pytest

from hannes import Hand, load_experiment
from hannes.bench.simulated_board import SimulatedBoard
from hannes.bench.virtual_hand import VirtualHand
from hannes.dataset.make import make
from hannes.dataset.spec import read_spec
from hannes.recognition import model_file
from hannes.recognition.train import train
from hannes.simulation.experiment.experiment import Target

GRASPS = """
title = "some grasps"
seed = 7
duration = "1.15 s"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.637 s", "9.84 rad"]]
[values]
"noise.current" = "10 mA"
"command.knee" = { uniform = ["4 rad", "9 rad"] }
"command.share" = { uniform = ["0.4", "0.6"] }
"object.stiffness" = ["800 N/m", "2 kN/m", "15 kN/m", "38.3 kN/m"]
[[grasps]]
name = "cylinders"
shape = "cylinder"
draws = 25
[grasps.values]
"object.radius" = { uniform = ["20 mm", "28 mm"] }
"""


@pytest.fixture(scope="session")
def model(tmp_path_factory):
    """A model trained on a hundred grasps of fixed objects."""
    path = tmp_path_factory.mktemp("held") / "set.h5"
    make(read_spec(GRASPS), path, workers=1, progress=False)
    return train(path, trees=12, seed=1, jobs=1)[0]


@pytest.fixture(scope="session")
def model_path(model, tmp_path_factory):
    """The same as a file."""
    path = tmp_path_factory.mktemp("model") / "model.h5"
    model_file.write(path, model)
    return path


def holding(stiffness, **values):
    """A virtual hand about a fixed cylinder of `stiffness` [N/m]."""
    (variant,) = load_experiment("dynamometer")
    target = Target("cylinder", {"object.stiffness": stiffness})
    experiment = replace(variant.experiment, object=target, noise={}, controller="sampled")
    return VirtualHand(Hand().with_values(values), experiment)


@pytest.fixture
def board():
    """Makes a simulated board that holds an object of a stiffness [N/m]."""
    return lambda stiffness, **values: SimulatedBoard(holding(stiffness, **values))
