"""The MuJoCo model that `hannes hand --mjcf` prints: it opens, rests, and closes as ours does."""

import numpy as np
import pytest

from hannes import Hand, load_experiment, simulate
from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.simulation.hand.anatomy import JOINTS
from hannes.simulation.hand.mjcf import LEFT_OUT, inverse_inertia, mjcf

mujoco = pytest.importorskip("mujoco")


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_string(mjcf(Hand()))


def test_command_prints_a_model_that_says_what_it_leaves_out(capsys, model):
    assert main(["hand", "--mjcf"]) == 0
    printed = capsys.readouterr().out
    assert printed == mjcf(Hand())
    for law, words in LEFT_OUT.items():
        assert f"{law}: {words}" in printed
    names = [model.joint(k).name for k in range(model.njnt)]
    assert names == ["motor", "cart_a", "cart_b", *JOINTS]


def test_inverse_inertias_are_mujocos_own(model):
    """They scale constraints, and are computed here without MuJoCo."""
    for k in range(model.njnt):
        wanted = model.dof_invweight0[k]
        found = inverse_inertia(Hand().parameters, model.joint(k).name)
        assert found == pytest.approx(wanted, rel=1e-6)


def test_open_hand_rests(model):
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    first = data.qpos.copy()
    for _ in range(2000):
        mujoco.mj_step(model, data)
    assert np.abs(data.qpos[3:] - first[3:]).max() < 2e-3


def test_free_closure_asks_for_the_same_torque_and_tension():
    """Driven through our motor's angle: RMS within 3 % of the range, to the turn of the command.

    No finger reaches a stop before.
    """
    from benchmarks.mjcf import CHANNELS, TURN, row, traces
    from benchmarks.mujoco.published import driven

    asked = load_experiment("void-closure")[0]
    ran = simulate(asked.hand, asked.experiment)
    ends = [asked.hand.parameters[".end_".join(name.split("_"))] for name in JOINTS]
    assert (ran["joint_angle"] < ends).all()
    closing = ran.time < TURN
    ours = {name: each[closing] for name, each in traces(asked.hand, ran).items()}
    theirs = driven(asked.hand, ran.time[closing], ran["motor_angle"][closing])
    found = row("", ours, theirs, np.ones(closing.sum(), bool))
    assert all(found[name] < 3.0 for name in CHANNELS)


def test_what_mujoco_has_no_element_for_is_refused():
    slack = Hand(["leader_slack"]).with_values({"leader_slack.length": 2e-3})
    with pytest.raises(BadInput, match="leader_slack"):
        mjcf(slack)
