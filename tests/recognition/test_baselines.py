"""The two ways to stiffness without a classifier, on features whose stiffness is known."""

import numpy as np
import pytest

from hannes import BadInput, Hand
from hannes.recognition.baselines import FREE, MOST, PEAK, SECANT, analytic, look_up
from hannes.recognition.features import NAMES
from hannes.recognition.model import RISE, SINCE
from hannes.recognition.training_set import Grasps


def rows(count):
    """Features of windows in which an object is held."""
    made = np.zeros((count, len(NAMES)))
    made[:, SINCE], made[:, RISE] = 0.1, 1.0
    return made


def test_the_analytic_estimate_solves_one_joint_with_wires_in_series():
    values, true = Hand().parameters, np.array([500.0, 5e3, 4e4])
    theta = 1e-3  # rad of the shaft
    per_finger = values["gear.pulley_radius"] / 5.0 / values["mcp.moment_arm"]
    reach = values["index.second_length"] + 0.5 * values["index.third_length"]
    of_object = true * (2.0 * reach * per_finger) ** 2  # N m/rad, wires rigid
    of_wires = values["gear.pulley_radius"] ** 2 / (
        1.0 / values["leader.stiffness"] + 5.0 / values["follower.stiffness"]
    )
    torque = theta / (1.0 / of_object + 1.0 / of_wires)
    features = rows(3)
    features[:, SECANT] = torque / theta / (19.0 * values["motor.torque_constant"])
    assert analytic(values)(features) == pytest.approx(true)
    features[:, SECANT] = 10.0 * of_wires  # stiffer than the wires can be
    assert analytic(values)(features) == pytest.approx(MOST)


def test_the_table_rises_and_gives_back_the_grasps_it_was_made_of():
    rng = np.random.default_rng(0)
    current = rng.uniform(0.2, 2.0, 40)
    features = np.stack([rows(5) for _ in current])
    features[..., FREE], features[..., PEAK] = 0.1, current[:, np.newaxis]
    stiffness = 1e3 * current**2
    nothing = np.zeros(40)
    known = Grasps(features, nothing, nothing, nothing, stiffness, nothing, np.ones((40, 5), bool))
    table = look_up(known, "made.h5")
    assert (np.diff(table.stiffness) >= 0.0).all()
    assert table(features[:, 0]) == pytest.approx(stiffness)


def test_a_data_set_without_a_held_grasp_is_refused():
    none, empty = np.zeros((4, 5, len(NAMES))), np.zeros(4)
    known = Grasps(none, empty, empty, empty, empty, empty, np.zeros((4, 5), bool))
    with pytest.raises(BadInput, match=r"made\.h5: expected training grasps that hold"):
        look_up(known, "made.h5")
