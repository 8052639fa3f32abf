"""The motor-driven axis: its integration, its friction, and the EMPS records it was made for."""

import numpy as np
import pytest

from hannes.campaigns import third_party
from hannes.campaigns.convert import convert
from hannes.core.effect import Effect, Term
from hannes.core.errors import BadInput, MissingRecording
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter
from hannes.core.recording.recording import Recording
from hannes.plants.axis.plant import EQUATIONS, Axis, start_state
from hannes.simulation.catalogue import effect
from hannes.simulation.compiler.assemble import assemble


def swing(duration: float = 2.0) -> Recording:
    """A record with a smooth reference; the measured channels are not used by the tests."""
    t = np.arange(round(duration * 1000) + 1) / 1000.0
    reference = 0.05 * (1.0 - np.cos(2.0 * np.pi * t))
    channels = {"time": t, "reference": reference, "position": reference, "drive": 0 * t}
    units = {"time": "s", "reference": "m", "position": "m", "drive": "V"}
    return Recording(channels, units, plant="axis")


def load(path, mapping="emps") -> Recording:
    """A MATLAB file of EMPS through its mapping."""
    (made,) = convert([path], mapping)
    return made.recording


def emps(name: str) -> Recording:
    mapping = "emps-pulses" if "PULSES" in name else "emps"
    try:
        return load(third_party.folder("emps") / name, mapping)
    except MissingRecording as error:
        pytest.skip(f"needs the EMPS recordings: {error}")


def test_more_substeps_change_nothing():
    few, many = (Axis().simulate({}, swing(), n)["drive"] for n in (2, 16))
    assert np.abs(few - many).max() < 1e-4 * np.abs(many).max()


def test_agrees_with_solve_ivp_from_tick_to_tick():
    from scipy.integrate import solve_ivp

    record, axis = swing(0.3), Axis()
    fast = assemble(EQUATIONS).fast
    p, reference = axis.parameters.vector(), np.array([record.time, record["reference"]])
    state = start_state(record)
    memory = np.array([0.0, state[0] - 1e-3 * state[1], state[0] - 2e-3 * state[1], 0.0])
    positions = []
    for start, end in zip(record.time[:-1], record.time[1:], strict=True):
        positions.append(state[0])
        fast.tick(start, state, p, reference, memory)
        part = solve_ivp(
            lambda t, y: fast.rates(t, y, p, reference, memory),
            (start, end),
            state,
            rtol=1e-10,
            atol=1e-13,
        )
        state = part.y[:, -1]
    ours = axis.simulate({}, record)["position"][:-1]
    assert np.abs(ours - positions).max() < 1e-8


def test_constant_speed_takes_the_published_force():
    """Far from any kink the drive carries Coulomb, viscous friction and offset alone."""
    t = np.arange(2001) / 1000.0
    units = {"time": "s", "reference": "m", "position": "m"}
    record = Recording({"time": t, "reference": 0.1 * t, "position": 0.1 * t}, units)
    p = Axis().parameters
    expected = p["motor.dry_friction"] + 0.1 * p["motor.viscous_friction"] + p["axis.offset"]
    simulated = Axis().simulate({}, record)["drive"][-500:]
    assert simulated == pytest.approx(expected / p["axis.force_gain"], rel=1e-6)


SPEEDS, FORCES = np.array([0.0, 0.05, 0.2, 1.0]), np.array([0.0, 1.0, 0.7, 0.6])


@kernel
def tabled(motor_speed, size):
    """Friction that was measured at some speeds; allocates [N]."""
    shares = np.zeros(2)
    shares[0] = np.interp(abs(motor_speed), SPEEDS, FORCES)
    return size * np.sign(motor_speed) * shares.sum()


def test_a_kernel_may_look_up_a_table_and_allocate():
    amount = Parameter("size", 0.0, "N", (0.0, 50.0), "how much", off=0.0)
    term = Term(tabled, writes=("gear_friction",))
    mine = Effect("tabled", "made for a test", "table", "none (2026)", (amount,), (term,))
    axis = Axis().with_effects(mine)
    fast = assemble(EQUATIONS, (mine,)).fast
    p, memory = axis.parameters.with_values({"tabled.size": 10.0}).vector(), np.zeros(4)
    reference, y = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([0.0, 0.1])
    bare = fast.rates(0.0, y, axis.parameters.vector(), reference, memory)
    made = fast.rates(0.0, y, p, reference, memory)
    expected = -10.0 * np.interp(0.1, SPEEDS, FORCES) / axis.parameters["axis.mass"]
    assert made[1] - bare[1] == pytest.approx(expected, rel=1e-9)
    slopes, differences = (
        each(0.0, y, p, reference, memory) for each in (fast.jacobian, fast.differences)
    )
    assert slopes == pytest.approx(differences, rel=1e-4, abs=1e-6)


def test_direction_friction_acts_by_direction():
    axis = Axis().with_effects(effect("direction_friction"))
    plain = axis.simulate({}, swing())
    assert np.array_equal(plain["drive"], Axis().simulate({}, swing())["drive"])
    other = axis.simulate({"direction_friction.viscous": 0.2}, swing())
    forth, back = (axis.phases(swing())[name] for name in ("forth", "back"))
    more = other["drive"] - plain["drive"]
    assert more[forth].mean() > 0.1 and more[back].mean() > 0.1


def test_effects_of_the_wire_do_not_fit():
    assert "slack" in Axis().accepts(effect("leader_slack"))
    assert Axis().accepts(effect("direction_friction")) == ""


def test_added_volts_come_behind_the_limit():
    record = swing()
    added = np.where((record.time > 1.0) & (record.time < 1.2), 5.0, 0.0)
    pushed = record.with_channels({"pulses": added}, {"pulses": "V"})
    jump = np.diff(Axis().simulate({}, pushed)["drive"])[np.flatnonzero(np.diff(added))]
    assert np.abs(np.abs(jump) - 5.0).max() < 0.5


@pytest.mark.parametrize("content", [b"", b"not MATLAB at all", b"MATLAB 5.0" + b"\0" * 200])
def test_a_file_that_is_no_record(tmp_path, content):
    path = tmp_path / "broken.mat"
    path.write_bytes(content)
    with pytest.raises(BadInput, match=r"broken\.mat"):
        load(path)


def test_a_damaged_matlab_file_is_one_line(tmp_path):
    from scipy.io import savemat

    names = dict.fromkeys(("t", "qg", "qm", "vir"), np.arange(3000.0))
    savemat(tmp_path / "r.mat", names, do_compression=True)
    whole = (tmp_path / "r.mat").read_bytes()
    for place in range(136, len(whole), 97):
        (tmp_path / "r.mat").write_bytes(whole[:place] + b"\xff\x00" + whole[place + 2 :])
        try:
            load(tmp_path / "r.mat")
        except BadInput as error:
            assert "r.mat" in str(error)


def test_a_matlab_file_with_other_names(tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "other.mat", {"t": np.arange(3.0)})
    with pytest.raises(BadInput, match=r'holds no "qg".*it has t'):
        load(tmp_path / "other.mat")


@pytest.mark.parametrize(("name", "bound"), [("DATA_EMPS.mat", 4.6), ("DATA_EMPS_PULSES.mat", 5.6)])
def test_published_parameters_on_emps(name, bound):
    """100 |vir - sim| / |vir| from 0.1 s to the end less 0.05 s, start state from the record."""
    record, axis = emps(name), Axis()
    part = axis.judged_part(record)
    miss = record["drive"] - axis.simulate({}, record)["drive"]
    assert 100 * np.linalg.norm(miss[part]) / np.linalg.norm(record["drive"][part]) < bound


def test_slow_friction_is_gone_at_speed_and_there_at_a_crawl():
    slow = Axis.catalogue["slow_friction"]
    axis, values = Axis().with_effects(slow), {"slow_friction.force": -6.0}
    t = np.arange(1001) / 1000.0
    units = {"time": "s", "reference": "m", "position": "m"}
    for speed, share in ((0.1, 0.0), (0.01, np.exp(-0.25))):
        record = Recording({"time": t, "reference": speed * t, "position": speed * t}, units)
        drives = [axis.simulate(given, record)["drive"][-200:] for given in (values, {})]
        force = (drives[0] - drives[1]) * axis.parameters["axis.force_gain"]
        assert force == pytest.approx(-6.0 * share, abs=0.05)


def test_an_effect_with_a_state_of_its_own_runs():
    """Grease that warms leaves less friction, and so asks for fewer volts, the longer it runs."""
    plant, record = Axis().with_effects(effect("warming_grease")), swing()
    plain = plant.simulate({}, record)
    warm = plant.simulate({"warming_grease.fall": 0.05}, record)
    late = record.time > 0.5 * record.time[-1]
    assert np.abs(warm["drive"][late]).mean() < 0.99 * np.abs(plain["drive"][late]).mean()
