"""Grasps near another one in lanes: the bits of one at a time, whatever shares the registers."""

import numpy as np
import pytest
from catalogued import CATALOGUE, EVERYTHING, RANGES
from runs import grasp

from hannes.core.effect import Effect, Term
from hannes.core.errors import BadInput
from hannes.core.kernels.jit import compiles, kernel
from hannes.core.parameter import Parameter
from hannes.simulation.batch import in_step
from hannes.simulation.batch import lanes as batch
from hannes.simulation.batch.simulate_many import simulate_alike
from hannes.simulation.compiler.lanes import machine
from hannes.simulation.hand.hand import Hand
from hannes.simulation.trajectory import Outcome

pytestmark = pytest.mark.skipif(not compiles(), reason="nothing is compiled")
CHANNELS = ("position", "current", "force", "phalanx_force", "joint_angle", "motor_speed")
COUNT = 12


def near(names, count=COUNT, share=1e-3):
    """Columns whose first row is the hand, each other row another along one of `names`."""
    shipped, columns = Hand().parameters, {}
    for k, name in enumerate(names):
        change = share * (np.arange(count) % len(names) == k) * np.linspace(0.5, 1.5, count)
        change[0] = 0.0
        columns[name] = shipped[name] * (1.0 + change)
    return columns


NEAR = near(("motor.dry_friction", "mcp.moment_arm", "object.stiffness", "gear.ratio"))
FAR = {"object.stiffness": np.linspace(800.0, 9000.0, COUNT), "index.rest_mcp": 0.22}
SIZES = {"object.radius": np.linspace(0.02, 0.03, COUNT)}


@pytest.fixture
def lanes(monkeypatch):
    """Sets how many lanes there are, notes which ran; their code is compiled at once."""
    monkeypatch.setattr(batch, "COMPILING", -1.0)
    ran, group = set(), in_step.InStep.run

    def noted(self, *given):
        ran.add(self.made.width)
        return group(self, *given)

    def chosen(width):
        monkeypatch.setattr(machine, "width", lambda: width)

    monkeypatch.setattr(in_step.InStep, "run", noted)
    chosen.ran = ran
    return chosen


def bits(found):
    """What must be the same of grasps, seconds aside."""
    return [
        (
            *(each.number, each.outcome, each.cost.evaluations, each.cost.jacobians),
            *(each.time.tobytes(), *(each[name].tobytes() for name in CHANNELS)),
        )
        for each in found
    ]


def run(columns, hand=None, experiment=None, rtol=1e-4):
    """Grasps by the steps of the first."""
    hand = hand or Hand()
    how = {"channels": CHANNELS, "rtol": rtol, "effects": hand.effects}
    return simulate_alike(hand, experiment or grasp(duration=0.7), columns, **how)


@pytest.mark.parametrize("columns", [NEAR, FAR, SIZES], ids=["near", "far", "sizes"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-2])
def test_lanes_have_the_bits_of_one_at_a_time(lanes, columns, rtol):
    lanes(1)
    expected = bits(run(columns, rtol=rtol))
    for width in (8, 4):
        lanes(width)
        assert bits(run(columns, rtol=rtol)) == expected
    assert lanes.ran == {8, 4}


def test_bits_do_not_depend_on_what_shares_the_registers(lanes, monkeypatch):
    lanes(8)
    expected = dict(enumerate(bits(run(FAR))))
    rows = np.array([0, *np.random.default_rng(4).permutation(np.arange(1, COUNT))])
    mixed = {name: np.broadcast_to(column, COUNT)[rows] for name, column in FAR.items()}
    for cores in (1, 2, 3):
        monkeypatch.setattr("hannes.simulation.batch.simulate_many._cores", lambda n=cores: n)
        for row, found in zip(rows, bits(run(mixed)), strict=True):
            assert found[1:] == expected[int(row)][1:]
    assert lanes.ran == {8}


def test_the_whole_catalogue_has_the_bits_of_one_at_a_time(lanes):
    names = [n for n in RANGES if n.partition(".")[0] in CATALOGUE]
    columns = {n: RANGES[n].low + 0.1 * (RANGES[n].high - RANGES[n].low) for n in names}
    columns["mcp.moment_arm"] = 0.01 * np.linspace(1.0, 1.01, COUNT)
    lanes(1)
    expected = bits(run(columns, EVERYTHING, grasp(duration=0.2)))
    assert expected[0][1] is Outcome.COMPLETED
    lanes(8)
    assert bits(run(columns, EVERYTHING, grasp(duration=0.2))) == expected
    assert lanes.ran == {8}


def test_a_lane_that_breaks_is_named_and_touches_no_other(lanes):
    way = np.zeros(COUNT)
    way[[2, 5, 9]] = 1.0, 2.0, 3.0
    columns = {"breaking.way": way, "mcp.moment_arm": 0.01 * np.linspace(1.0, 1.01, COUNT)}
    found = {}
    for width in (1, 8):
        lanes(width)
        found[width] = run(columns, EVERYTHING, grasp(duration=0.2))
    assert bits(found[8]) == bits(found[1]) and lanes.ran == {8}
    broken = [each.outcome is not Outcome.COMPLETED for each in found[8]]
    assert broken == (way != 0.0).tolist()


def test_rows_with_other_stages_are_not_in_lanes_with_the_rest(lanes):
    columns = {"gravity.x": np.where(np.arange(COUNT) % 2, 9.81, 0.0), **NEAR}
    lanes(1)
    expected = bits(run(columns))
    lanes(8)
    assert bits(run(columns)) == expected


@kernel
def of_a_list(motor_speed, size):
    """A torque that is written in a way that lanes do not have."""
    return [-size * motor_speed][0]


OWN = Effect("listed", "A torque.", "-", "a test",
             (Parameter("size", 1e-7, "N m s/rad", (0.0, 1.0), "its size", off=0.0),),
             (Term(of_a_list, ("motor_torque",)),))  # fmt: skip


def test_an_effect_that_has_no_lanes_runs_one_by_one_and_says_so(lanes, capsys):
    hand, short = Hand((OWN,)), grasp(duration=0.1)
    lanes(1)
    expected = bits(run(NEAR, hand, short))
    lanes(8)
    capsys.readouterr()
    assert bits(run(NEAR, hand, short)) == expected
    said = capsys.readouterr().err
    assert said.count("one by one") == 1 and "[-size * motor_speed]" in said
    run(NEAR, hand, short)
    assert not capsys.readouterr().err


def test_lanes_are_compiled_once_single_grasps_have_taken_as_long(monkeypatch):
    made = []

    def compile_lanes(*key):
        made.append(key)
        return in_step_kernels(*key)

    in_step_kernels = batch.Kernels
    monkeypatch.setattr(machine, "width", lambda: 2)
    monkeypatch.setattr(batch, "Kernels", compile_lanes)
    monkeypatch.setattr(batch, "_made", {})
    monkeypatch.setattr(batch, "_spent", {})
    monkeypatch.setattr(batch, "is_kept", lambda *key: False)
    monkeypatch.setattr(batch, "COMPILING", 1e9)
    expected = bits(run(NEAR, experiment=grasp(duration=0.1)))
    assert not made and sum(batch._spent.values()) > 0.0
    monkeypatch.setattr(batch, "COMPILING", 1e-9)
    assert bits(run(NEAR, experiment=grasp(duration=0.1))) == expected
    assert len(made) == 1


def test_a_number_of_lanes_that_there_is_not_is_refused(monkeypatch):
    monkeypatch.setenv("HANNES_LANES", "3")
    with pytest.raises(BadInput, match="expected 1, 2, 4 or 8"):
        machine.width.__wrapped__()
    monkeypatch.setenv("HANNES_LANES", "2")
    assert machine.width.__wrapped__() == 2


def test_code_that_cannot_be_kept_is_used_and_said(tmp_path, monkeypatch, capsys):
    def full(path, data):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(machine, "write_bytes", full)
    machine._keep(tmp_path / "lanes.o", b"code")
    assert "cannot be kept (No space left on device)" in capsys.readouterr().err
