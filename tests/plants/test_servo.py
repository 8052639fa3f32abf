"""The geared servo of examples/servo: closed forms, its effects, its ranges, what is found."""

import inspect
import json
import math
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.check import check
from hannes.commands.cli import main
from hannes.core.errors import BadInput, ComputationFailed
from hannes.core.kernels.jit import plain
from hannes.core.layout import Layout
from hannes.core.recording.recording import Recording
from hannes.plants.plain import PlainPlant
from hannes.plants.protocol import Plant, find_plant
from hannes.simulation.catalogue import effects

EXAMPLE = Path(__file__).parents[2] / "examples" / "servo"
UNITS = {"time": "s", "reference": "rad", "position": "rad"}


@pytest.fixture(scope="module")
def servo():
    return find_plant("servo:Servo", EXAMPLE)


@pytest.fixture(scope="module")
def whole(servo):
    """With all effects that fit, in one compilation."""
    known = {**effects(), **servo.catalogue}
    return servo.with_effects(*(each for each in known.values() if not servo.accepts(each)))


def recording(reference, start=0.0, step=0.01):
    time = step * np.arange(len(reference))
    channels = {"time": time, "reference": np.asarray(reference), "position": start + 0.0 * time}
    return Recording(channels, UNITS)


def steps(size=0.6):
    return recording(np.repeat([0.0, size, -size, 0.0], 80))


def test_it_takes_the_effects_of_a_geared_motor(servo, whole):
    assert isinstance(servo, Plant)
    assert {each.name for each in whole.effects} >= {
        *("breakaway", "command_delay", "command_lag", "direction_friction", "gear_backlash"),
        *(
            "gear_load",
            "pwm_dead_band",
            "stribeck",
            "supply_sag",
            "winding_heating",
            "wrong_gravity",
        ),
    }
    assert "leader" in servo.accepts(effects()["wire_compliance"])
    assert "finer" in servo.accepts(effects()["torque_ripple"])


def test_off_effects_change_nothing(servo, whole):
    run = steps()
    alone, off = (each.simulate({}, run) for each in (servo, whole))
    assert all(np.array_equal(alone[name], off[name]) for name in servo.judged)


def test_a_held_shaft_stays_where_it_is(servo):
    """Dry friction of 0.15 N m carries a load of 0.1 N m, however long."""
    heavy = {"gravity.torque": 0.1, "gravity.angle": math.pi / 2.0, "control.gain": 0.1}
    found = servo.simulate(heavy, recording(np.zeros(2000)))
    assert np.abs(found["position"]).max() < 2e-3


def test_without_friction_and_gravity_it_is_a_second_order_lag(servo):
    """Within its limits: J w' = k (gain e V - k w) / R, whose step response is a textbook's."""
    free = {"motor.dry_friction": 0.0, "motor.viscous_friction": 0.0, "gravity.torque": 0.0}
    run = recording(np.r_[np.zeros(10), np.full(90, 0.05)])
    found = servo.simulate(free, run)["position"]
    p = servo.parameters
    k, r, n = p["motor.torque_constant"], p["motor.resistance"], p["gear.ratio"]
    decay = k * k / r / p["motor.inertia"] / 2.0
    square = k * p["control.gain"] * p["supply.voltage"] / r / n / p["motor.inertia"]
    swing = math.sqrt(square - decay**2)
    t = np.maximum(run.time - 0.1, 0.0)
    wave = np.cos(swing * t) + decay / swing * np.sin(swing * t)
    assert np.abs(found - 0.05 * (1.0 - np.exp(-decay * t) * wave)).max() < 1e-4


def test_a_delay_of_any_size_shows(whole):
    """A tenth of a step of integration and ten steps: each shifts the run by itself."""
    run, speed = steps(), None
    here = whole.simulate({}, run)["position"]
    speed = np.gradient(here, run.time)
    for delay in (2e-4, 2e-3):
        late = whole.simulate({"command_delay.time": delay}, run)["position"]
        assert float(speed @ (here - late)) / float(speed @ speed) == pytest.approx(delay, rel=0.1)


def test_play_shows_where_gravity_changes_sides(whole):
    """Past the place where the load hangs down, -0.3 rad, the shaft has crossed the whole play.

    Elsewhere it is carried along, and its own friction is that of a tight one beside the motor's.
    """
    run = recording(np.linspace(0.5, -1.1, 400), start=0.5)
    place = {"gear_backlash.gap": 0.04, "gravity.torque": 1.5, "control.gain": 1.0}
    states = {"motor.dry_friction": 0.0, **place}
    loose = whole.simulate(states, run)
    rubbing = {"gear_backlash.gap": 0.0, "motor.dry_friction": 0.02 / 300.0}
    tight = whole.simulate({**states, **rubbing}, run)
    more = loose["position"] - tight["position"]
    assert np.abs(more).max() < 0.045
    drawn = np.abs(loose["current"] - tight["current"])
    crossing = np.abs(tight["position"] + 0.3) < 0.2
    assert drawn[crossing].max() > 3.0 * drawn[200:][~crossing[200:]].max()


def test_sag_and_gravity_do_as_written(whole):
    """At standstill the motor carries the load: i = T / (N k), whatever the supply does."""
    run = recording(np.full(150, 0.4), start=0.3)
    for values in ({"supply_sag.resistance": 1.0}, {"wrong_gravity.sine": 0.2}):
        found = whole.simulate({**values, "motor.dry_friction": 0.0}, run)
        q = found["position"][-1]
        load = 0.4 * math.sin(q + 0.3) + values.get("wrong_gravity.sine", 0.0) * math.sin(q)
        assert found["current"][-1] == pytest.approx(load / 300.0 / 3e-3, rel=1e-3)


def test_a_smoothed_command_is_a_first_order_lag(whole):
    """Steering stiffly, the shaft follows what a filter makes of a slow step; it starts at rest."""
    run = recording(0.3 + np.repeat([0.0, 0.2], [50, 150]), start=0.3)
    stiff = {"control.gain": 80.0, "motor.dry_friction": 0.0, "gravity.torque": 0.0}
    found = whole.simulate({**stiff, "command_lag.time": 0.3}, run)["position"]
    exact = 0.3 + 0.2 * (1.0 - np.exp(-np.maximum(run.time - 0.5, 0.0) / 0.3))
    assert np.abs(found[:50] - 0.3).max() < 1e-6
    assert np.abs(found - exact)[60:].max() < 0.012


def test_breakaway_holds_and_slow_motions_stick_and_slip(whole):
    """Of 0.15 N m in motion and 0.35 N m at rest a load of 0.3 N m is carried; a ramp has steps."""
    more = {"breakaway.torque": 7e-4, "breakaway.speed": 20.0}
    heavy = {"gravity.torque": 0.3, "gravity.angle": math.pi / 2.0, "control.gain": 0.1}
    held = whole.simulate({**more, **heavy}, recording(np.zeros(300)))["position"]
    assert np.abs(held).max() < 1e-3
    ramp = recording(0.01 * 0.01 * np.arange(1500))
    speed = {name: np.diff(whole.simulate(each, ramp)["position"])[300:] / 0.01
             for name, each in (("smooth", {}), ("jerky", more))}  # fmt: skip
    assert speed["smooth"].max() < 0.02 and speed["jerky"].max() > 0.05


def test_ranges_are_those_of_this_machine(servo, whole):
    shipped = effects()["stribeck"].parameters[0].bounds
    assert whole.parameters.declared["stribeck.torque"].bounds == (0.0, 2e-3) != shipped
    assert whole.with_effects(effects()["stribeck"]).effects == whole.effects
    assert PlainPlant().with_effects(effects()["stribeck"]).effects == (effects()["stribeck"],)


def test_what_runs_away_is_said(servo):
    run = steps()
    knots = np.array([run.time, run["reference"]])
    with pytest.raises(ComputationFailed, match="the simulated servo runs away"):
        servo.run({}, run.time, knots, (math.inf, 0.0), 2e-3)


def test_held_steps_are_refused_for_another_kind_of_machine(servo):
    run, one = steps(), Layout(servo.compiled_from.states.slots[:1])
    knots = np.array([run.time, run["reference"]])
    first_order = type("FirstOrder", (type(servo),), {
        "compiled_from": replace(servo.compiled_from, states=one),
    })()  # fmt: skip
    for plant, start, step in ((first_order, (0.0,), 2e-3), (servo, (0.0, 0.0), 0.0),
                               (servo, (0.0, 0.0, 0.0), 2e-3)):  # fmt: skip
        with pytest.raises(BadInput, match="cannot run by held steps"):
            plant.run({}, run.time, knots, start, step)


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [("equations.py", "gear", "step"), ("laws.py", "rubbing", "slope")],
)
def test_a_function_of_a_name_that_is_taken_is_refused(tmp_path, file, old, new):
    """It would be replaced in silence: all that runs the equations is one text with them."""
    for each in EXAMPLE.glob("*.py"):
        text = each.read_text(encoding="utf-8")
        if each.name in (file, "equations.py"):
            text = re.sub(rf"\b{old}\b(?=\(|,)", new, text)
        (tmp_path / each.name).write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=f"equations.py: {new} is the name of a function"):
        _ = find_plant("servo:Servo", tmp_path).compiled


@pytest.fixture(scope="module")
def rubbing(tmp_path_factory):
    folder = tmp_path_factory.mktemp("servo")
    for file in EXAMPLE.glob("*.*"):
        shutil.copy(file, folder)
    command = [sys.executable, "record.py", "--runs", "3"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder / "campaign.toml"


def test_its_recordings_are_clean_and_its_ranges_reach_the_campaign(rubbing):
    campaign = read_campaign(rubbing, trust=True)
    for entry in campaign.entries:
        assert "fault" not in {each.level for each in check(entry.recording, campaign.plant)}
    bounds = [each.bounds for each in campaign.effects["stribeck"].parameters]
    assert bounds == [(0.0, 2e-3), (2.0, 300.0)]


def test_a_range_of_what_no_effect_has_is_refused(rubbing, tmp_path):
    folder = shutil.copytree(rubbing.parent, tmp_path / "servo")
    plant = folder / "servo.py"
    plant.write_text(plant.read_text().replace('"stribeck.torque"', '"stribeck.torqe"'))
    with pytest.raises(BadInput, match=r'"stribeck.torqe", which no effect has.*stribeck.torque'):
        read_campaign(folder / "campaign.toml", trust=True)


@pytest.mark.slow
def test_friction_under_load_is_named(rubbing, capsys):
    out = rubbing.parent / "out"
    assert main(["diagnose", str(rubbing), "--trust", "--out", str(out), "--json"]) == 0
    verdict = json.loads(capsys.readouterr().out)
    assert verdict["effects"] == ["gear_load"]
    size = verdict["parameters"]["gear_load.coefficient"]
    assert size["value"] == pytest.approx(0.3, rel=0.2)


def test_a_servo_that_sinks_when_let_go_starts_where_it_was(servo):
    """Held by the hand until the log begins, a load of 0.6 N m pulls it down in 0.1 s."""
    heavy, still = {"gravity.torque": 0.6, "gravity.angle": 0.6}, np.zeros(40)
    seen = servo.simulate(heavy, recording(still, start=0.2))["position"]
    assert abs(seen[-1] - seen[0]) > 0.05
    noisy = seen + 1e-3 * np.random.default_rng(0).standard_normal(seen.size)
    run = Recording({"time": 0.01 * np.arange(40), "reference": still, "position": noisy}, UNITS)
    assert servo.simulate(heavy, run)["position"][0] == pytest.approx(0.2, abs=3e-3)
    resting = Recording({**run.channels, "position": noisy - seen + 0.2}, UNITS)
    assert servo.simulate({}, resting)["position"][0] == pytest.approx(0.2, abs=5e-4)


def test_a_servo_that_sinks_by_a_few_counts_starts_where_it_was_too(servo):
    """3.4 mrad in 70 ms under a sensor's noise of 1 mrad, in the mean of four runs; or none."""
    rng, rest = np.random.default_rng(1), inspect.getmodule(type(servo)).rest
    path = -1e-3 * np.array([0.0, 0.31, 1.03, 1.86, 2.57, 3.07, 3.33, *[3.39] * 8])
    asked, off = np.append(np.zeros(15), 1.0), {"sinks": [], "holds": []}
    for _ in range(30):
        noise = 5e-4 * rng.standard_normal(16)
        for name, moved in (("sinks", np.append(path, 0.0)), ("holds", 0.0)):
            off[name].append(rest({"reference": asked, "position": moved + noise}))
    rms = {name: np.sqrt(np.mean(np.square(each))) for name, each in off.items()}
    assert rms["sinks"] < 7e-4 and rms["holds"] < 2.5e-4


def test_derivative_action_brakes_near_the_target_alone(whole):
    """At the limit of its duty a servo runs as quickly; near its target it comes in late."""
    run = recording(np.repeat([0.0, 1.5], [10, 150]))
    plain, braked = (whole.simulate({"motor.dry_friction": 0.0, "gravity.torque": 0.0,
                                     "derivative_action.time": time}, run)["position"]
                     for time in (0.0, 0.05))  # fmt: skip
    assert np.abs(plain - braked)[:25].max() < 2e-4  # but where the command comes in
    near = slice(*np.searchsorted(plain, (1.3, 1.45)))
    assert (plain - braked)[near].min() > 0.02
    assert abs(braked[-1] - 1.5) < 1e-3


@pytest.mark.parametrize("beyond", [0.1, 0.5, 0.9])
def test_a_strike_keeps_the_momentum_of_shaft_and_rotor(servo, beyond):
    """(1 - b) J w' + b J n v' = 0, where nothing else pushes."""
    ahead, apart = (plain(each.kernel) for each in servo.catalogue["gear_backlash"].terms)
    inertia, ratio = 1e-7, 300.0
    gear = {"motor_speed": 30.0, "motor_inertia": inertia, "gear_ratio": ratio}
    place = {"gravity_torque": 0.0, "gravity_angle": 0.0, "first_command": 0.0}
    play = {"travelled": 1.0, "flight": 2.0, "gap": 0.01, "beyond": beyond}
    *_, rate = ahead(motor_angle=0.0, hold=0.0, **gear, **place, **play)
    push = apart(drive_torque=0.0, gear_friction=0.0, load=0.0, **gear, **place, **play)
    assert rate < 0.0 < push
    shaft, rotor = beyond * inertia * ratio * rate, (1.0 - beyond) * push
    assert rotor == pytest.approx(-shaft, rel=1e-12)


@pytest.mark.parametrize("beyond", [0.02, 0.9])
def test_play_is_simulated_whatever_share_is_beyond(whole, beyond):
    found = whole.simulate({"gear_backlash.gap": 0.03, "gear_backlash.beyond": beyond}, steps())
    bare = whole.simulate({}, steps())
    assert np.abs(found["position"] - bare["position"]).max() < 0.2


def test_rare_counts_of_an_encoder_at_rest_are_no_fall(servo):
    still = np.zeros(400)
    still[[250, 300, 390]] = 2.0 * math.pi / 4096.0
    run = recording(np.repeat([0.0, 0.5], 400))
    shown = Recording({**run.channels, "position": np.append(still, still)}, UNITS)
    began = servo.simulate({}, shown)["position"][0]
    assert began == pytest.approx(still.mean(), abs=1e-9)
    assert servo.simulate({}, run)["position"][0] == 0.0
