"""Stiction: a grasp that holds keeps its force, where the paper's friction lets it creep."""

import numpy as np
import pytest

from hannes.core.errors import BadInput
from hannes.simulation.batch.simulate_many import simulate_many
from hannes.simulation.catalogue import effects, laws
from hannes.simulation.experiment.experiment import Experiment, Reference, Target
from hannes.simulation.experiment.load import read
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import hand_toml

HELD = slice(100, 1101)  # samples from 1 s to 11 s


def forces(stiffness, hand):
    """Grip force on cylinders of these stiffnesses [N/m], closed in 0.5 s and held to 11 s."""
    reference = Reference([[0.0, 0.5], [0.0, 7.7]])
    held = Experiment("held", 11.0, reference, Target("cylinder"), sampling=100.0)
    made = simulate_many(
        hand, held, {"object.stiffness": stiffness}, channels=("force",), workers=1
    )
    return np.array([each.require()["force"] for each in made])


@pytest.mark.slow
def test_a_held_grasp_keeps_its_force_for_ten_seconds():
    hand = Hand(["stiction"]).with_values({"stiction.share": 1.0})
    force = forces([800.0, 5000.0, 38300.0], hand)[:, HELD]
    assert (force[:, 0] > 40.0).all()
    assert (np.ptp(force, axis=1) < 0.02 * force[:, 0]).all()


def test_without_it_a_stiff_grip_creeps():
    (force,) = forces([38300.0], Hand())
    assert np.ptp(force[HELD]) > 0.04 * force[HELD][0]


def test_it_is_a_law_by_name_and_no_guess_of_a_diagnosis():
    assert "stiction" in laws() and "stiction" not in effects()
    hand = Hand(["stiction"]).with_values({"stiction.share": 0.5})
    assert 'effects = [\n    "stiction",\n]' in hand_toml(hand)
    assert Hand(["stiction"]).compiled() is Hand().compiled()  # at off it is left out
    text = 'effects = ["stickion"]\n[reference]\nkind = "ramp"\npoints = [["0 s", "0 rad"]]'
    with pytest.raises(BadInput, match='did you mean "stiction"'):
        read(text, "x.toml")
