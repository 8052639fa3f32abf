"""object_misplacement: its equation written a second time, its signature in a run."""

from dataclasses import replace

import numpy as np
from catalogued import EVERYTHING, EXPERIMENTS
from effect_contract import check_equations, parameter, runs

from hannes.simulation.experiment.experiment import Target
from hannes.simulation.simulate import simulate


def test_equation():
    check_equations("object_misplacement", {"moved": lambda x, y: (x, y)})


def test_signature():
    bare, run = runs("object_misplacement", "dynamometer", x=2e-3)
    values = {"object.x": parameter("object.x") + 2e-3}
    there = replace(EXPERIMENTS["dynamometer"], object=Target("cylinder", values))
    same = simulate(EVERYTHING, there, rtol=1e-6, effects=EVERYTHING.effects).require()
    assert np.abs(run["force"] - same["force"]).max() < 1e-6 * same["force"].max()
    assert np.abs(run["force"] - bare["force"]).max() > 0.05 * bare["force"].max()


def test_signature_of_y():
    _, run = runs("object_misplacement", "dynamometer", y=2e-3)
    values = {"object.y": parameter("object.y") + 2e-3}
    there = replace(EXPERIMENTS["dynamometer"], object=Target("cylinder", values))
    same = simulate(EVERYTHING, there, rtol=1e-6, effects=EVERYTHING.effects).require()
    assert np.abs(run["force"] - same["force"]).max() < 1e-6 * same["force"].max()
