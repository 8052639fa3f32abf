"""Joints with values of their own: packed where they belong, and nothing else changes."""

import numpy as np

from hannes.simulation.hand import variables
from hannes.simulation.hand.anatomy import FINGERS, JOINTS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.joint_shares import QUANTITIES, joint_value


def packed(hand, quantity):
    """A quantity of the ten joints as compiled code reads it."""
    compiled = hand.compiled(())
    return hand.vector(None)[compiled.parameters[f"joint_{quantity}"]][: len(JOINTS)]


def test_a_share_moves_its_own_joint_alone():
    hand = Hand()
    for finger in FINGERS:
        for kind in ("mcp", "pip"):
            for quantity in QUANTITIES:
                moved = hand.with_values({f"{finger}.{kind}_{quantity}": 0.5})
                place = JOINTS.index(f"{finger}_{kind}")
                factor = np.ones(len(JOINTS))
                factor[place] = 0.5
                assert np.array_equal(packed(moved, quantity), factor * packed(hand, quantity))
                changed = np.flatnonzero(moved.vector(None) != hand.vector(None))
                assert set(changed) <= set(
                    place for place, name in enumerate(variables.PACKED) if quantity in name
                )
                assert (
                    joint_value(moved.parameters, JOINTS[place], quantity)
                    == (packed(moved, quantity)[place])
                )


def test_all_fingers_with_one_share_are_the_shared_value():
    shares = {f"{finger}.mcp_moment_arm": 1.25 for finger in FINGERS}
    common = Hand().with_values({"mcp.moment_arm": 1.25 * Hand().parameters["mcp.moment_arm"]})
    assert np.array_equal(Hand().with_values(shares).vector(None), common.vector(None))


def test_rows_of_columns_are_the_vectors_of_their_hands():
    hand = Hand().with_values({"index.pip_spring_stiffness": 0.8})
    rng = np.random.default_rng(1)
    names = ("pip.spring_stiffness", "index.pip_spring_stiffness", "thumb.mcp_coulomb_friction",
             "motor.resistance")  # fmt: skip
    columns = {name: hand.parameters[name] * rng.uniform(0.9, 1.1, 4) for name in names}
    rows = hand.vectors(None, 4, columns, ())
    for number, row in enumerate(rows):
        values = {name: float(each[number]) for name, each in columns.items()}
        assert np.array_equal(row, hand.with_values(values).vector(None))
