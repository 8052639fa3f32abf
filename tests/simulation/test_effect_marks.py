"""The mark that each effect leaves in a run: takes the run without and the run with the effect."""

import math
from dataclasses import replace

import numpy as np
import pytest
from catalogued import CATALOGUE, EVERYTHING, EXPERIMENTS, ran

from hannes.simulation.experiment.experiment import Target
from hannes.simulation.simulate import simulate


def sign(x):
    return np.tanh(x)


def mean(run, name, start, end):
    """Mean of a channel over part of a run."""
    inside = (run.time >= start) & (run.time < end)
    return float(run[name][inside].mean())


def touch(run):
    return run.time[np.argmax(run["force"] > 1.0)]


def slack(bare, run):
    speed = EVERYTHING.parameters["gear.pulley_radius"] * 9.84 / 0.637
    assert touch(run) - touch(bare) == pytest.approx(3e-3 / speed, rel=0.1)


def stretched(bare, run):
    """Compliance by the slope of stretch over tension, where neither moves much."""
    at = slice(610, 640)
    slopes = [
        np.polyfit(r["leader_tension"][at], r["leader_stretch"][at], 1)[0] for r in (bare, run)
    ]
    assert slopes[1] - slopes[0] == pytest.approx(5e-6, rel=0.05)


def follower_stretched(bare, run):
    arms = [EVERYTHING.parameters[f"{j}.moment_arm"] for j in ("mcp", "pip")]
    slopes = []
    for each in (bare, run):
        bend = each["joint_angle"] - each["joint_angle"][0]
        taken = bend.reshape(-1, 5, 2) @ arms
        stretch = 2.0 * each["cart_position"][:, 0] - taken[:, 0] - taken[:, 1]
        at = slice(610, 640)
        slopes.append(np.polyfit(each["follower_tension"][at, 0], stretch[at], 1)[0])
    assert slopes[1] - slopes[0] == pytest.approx(5e-6, rel=0.05)


def rubbed(bare, run):
    """Closing on nothing, two pulleys lie between the carts' means."""
    at = (run.time > 0.2) & (run.time < 0.25)
    before, after = (
        np.mean(r["follower_tension"][at, 1] / r["follower_tension"][at, 0]) for r in (bare, run)
    )
    assert after / before == pytest.approx(math.exp(-2.0 * 0.05 * math.pi), rel=0.01)
    assert mean(run, "current", 0.2, 0.25) > mean(bare, "current", 0.2, 0.25)


def torque(run, start, end):
    return EVERYTHING.parameters["motor.torque_constant"] * mean(run, "current", start, end)


def loaded(bare, run):
    arm = EVERYTHING.parameters["gear.pulley_radius"] / EVERYTHING.parameters["gear.ratio"]
    before, after = (arm * mean(r, "leader_tension", 0.4, 0.5) for r in (bare, run))
    more = torque(run, 0.4, 0.5) - torque(bare, 0.4, 0.5) - (after - before)
    assert more == pytest.approx(0.05 * after, rel=0.02) and after < before


def one_way(bare, run):
    for start, end in ((0.2, 0.3), (0.8, 0.9)):
        more = torque(run, start, end) - torque(bare, start, end)
        assert more == pytest.approx(0.2 * EVERYTHING.parameters["motor.dry_friction"], rel=0.05)


def one_way_viscous(bare, run):
    for start, end in ((0.2, 0.3), (0.8, 0.9)):
        more = torque(run, start, end) - torque(bare, start, end)
        speed = float(np.mean(np.abs(run["motor_speed"][int(1e3 * start) : int(1e3 * end)])))
        lost = 0.4 * EVERYTHING.parameters["motor.viscous_friction"] * speed
        assert more == pytest.approx(lost, rel=0.15)


def held_back(bare, run):
    speed = run["motor_speed"][1:]
    law = sign(speed / EVERYTHING.parameters["motor.friction_speed"])
    law *= EVERYTHING.parameters["motor.dry_friction"]
    more = run["power_gear_friction"][1:] / speed - law
    more -= EVERYTHING.parameters["motor.viscous_friction"] * speed
    assert more.max() == pytest.approx(2e-3, rel=1e-3)
    assert speed[np.argmax(more)] == pytest.approx(20.0, rel=0.02)
    behind = bare["motor_angle"] - run["motor_angle"]
    assert behind[200] > 0.1 * bare["motor_angle"][200] and abs(behind[-1]) < 0.1


def played(bare, run):
    """Half the play between motor and encoder; next to nothing in the log."""
    ratio = EVERYTHING.parameters["gear.ratio"]
    lost = run["motor_angle"][100:900] / ratio - run["position"][100:900]
    assert lost == pytest.approx(0.01, rel=1e-3)
    for name in ("position", "current", "duty"):
        assert np.abs(run[name] - bare[name])[100:900].max() < 2e-3 * np.ptp(bare[name])


def rippled(bare, run):
    at = slice(4000, 6000)
    speed, more = run["motor_speed"][at], run["motor_speed"][at] - bare["motor_speed"][at]
    expected = 1e-3 / (EVERYTHING.parameters["motor.inertia"] * 4.0 * speed.mean())
    assert more.std() * math.sqrt(2.0) == pytest.approx(expected, rel=0.1)
    turns = np.ptp(run["motor_angle"][at]) * 4.0 / (2.0 * math.pi)
    crossings = np.count_nonzero(np.diff(np.sign(more - more.mean())))
    assert crossings / 2.0 == pytest.approx(turns, abs=1.5)


def heated(bare, run):
    resists = run["power_copper"][1:] / run["motor_current"][1:] ** 2
    assert resists == pytest.approx(EVERYTHING.parameters["motor.resistance"] * 1.1965)
    more = mean(run, "current", 0.2, 0.3) / mean(bare, "current", 0.2, 0.3)
    assert more == pytest.approx(1.0 / 0.945, rel=0.01)


def sagged(bare, run):
    assert run["supply"] == pytest.approx(12.0 - 0.5 * run["duty"] * run["motor_current"])
    assert run["supply"].min() < 11.0 < 11.99 < bare["supply"].min()
    assert run["duty"].max() > bare["duty"].max()


def swallowed(bare, run):
    for start, end, sign in ((0.2, 0.3, 1.0), (0.8, 0.9, -1.0)):
        more = mean(run, "duty", start, end) - mean(bare, "duty", start, end)
        assert more == pytest.approx(sign * 0.03, abs=5e-4)


def stronger(bare, run):
    assert mean(run, "leader_tension", 0.2, 0.3) > mean(bare, "leader_tension", 0.2, 0.3)
    before, after = (np.cumsum(r["power_spring"])[600] for r in (bare, run))
    assert after / before == pytest.approx(1.2, rel=0.01)


def not_given_back(bare, run):
    """Over closing and opening, twice the share of what the springs take in closing is lost."""
    taken = np.cumsum(bare["power_spring"]) * 1e-3
    lost = np.sum(run["power_spring"]) * 1e-3 - taken[-1]
    assert lost == pytest.approx(2.0 * 0.2 * taken.max(), rel=0.25)  # less what turning takes


def deeper(bare, run):
    """Deeper than 1 mm, the ball is stiffer."""
    assert 1.2 < run["force"].max() / bare["force"].max() < 5.0**0.3
    assert touch(run) >= touch(bare)


def damped_with_depth(bare, run):
    """Harder to press, softer to let go: more is lost, by a tenth of a newton or so."""
    pressed, left = (run["force"] - bare["force"])[500:600], (run["force"] - bare["force"])[700:720]
    assert pressed.mean() > 0.1 > -0.1 > left.mean()
    assert run["power_contact_normal"].sum() > 1.02 * bare["power_contact_normal"].sum() > 0.0


def relaxed(bare, run):
    """Held, the grip on the ball fades."""
    fades = [r["force"][1450] / r["force"][700] for r in (bare, run)]
    assert fades[1] < fades[0] - 0.05
    assert run["force"].max() < bare["force"].max()


def misplaced(bare, run):
    values = {"object.x": EVERYTHING.parameters["object.x"] + 2e-3}
    there = replace(EXPERIMENTS["dynamometer"], object=Target("cylinder", values))
    same = simulate(EVERYTHING, there, rtol=1e-6, effects=EVERYTHING.effects).require()
    assert np.abs(run["force"] - same["force"]).max() < 1e-6 * same["force"].max()
    assert np.abs(run["force"] - bare["force"]).max() > 0.05 * bare["force"].max()


def misplaced_upwards(bare, run):
    values = {"object.y": EVERYTHING.parameters["object.y"] + 2e-3}
    there = replace(EXPERIMENTS["dynamometer"], object=Target("cylinder", values))
    same = simulate(EVERYTHING, there, rtol=1e-6, effects=EVERYTHING.effects).require()
    assert np.abs(run["force"] - same["force"]).max() < 1e-6 * same["force"].max()


def offset(bare, run):
    assert run["current"] - run["motor_current"] == pytest.approx(0.05)
    more = mean(run, "current", 0.2, 0.3) - mean(bare, "current", 0.2, 0.3)
    assert more == pytest.approx(0.05, rel=0.02)


def scaled(bare, run):
    assert run["current"] == pytest.approx(1.1 * run["motor_current"])
    more = mean(run, "current", 0.2, 0.3) / mean(bare, "current", 0.2, 0.3)
    assert more == pytest.approx(1.1, rel=0.01)


def smoothed(bare, run):
    """The log is an exponential mean of what flows."""
    now, told, time = run["motor_current"], run["current"], 2e-3
    mean, step = 0.5 * (now[1:] + now[:-1]), math.exp(-5e-5 / time)
    filtered = [0.0]
    for each in mean:
        filtered.append(step * filtered[-1] + (1.0 - step) * each)
    assert told == pytest.approx(np.array(filtered), abs=1e-4)
    assert np.abs(told - now).max() > 0.01


def force_trails(bare, run):
    for name in ("force", "sensor"):
        now, told, step = bare[name], run[name], math.exp(-1e-3 / 0.05)
        filtered = [0.0]
        for each in 0.5 * (now[1:] + now[:-1]):
            filtered.append(step * filtered[-1] + (1.0 - step) * each)
        assert np.abs(told - filtered).max() < 1e-3 * now.max()
    assert run["position"] == pytest.approx(bare["position"], abs=1e-4)


def all_late(bare, run):
    for name in ("position", "current", "force"):
        gap = np.abs(run[name][10:] - bare[name][:-10])
        assert gap.max() < 5e-5 * np.ptp(bare[name])


def told_late(bare, run):
    ratio, late = EVERYTHING.parameters["gear.ratio"], 80  # samples of 50 us
    for name, true in (("position", run["motor_angle"] / ratio), ("current", run["motor_current"])):
        told = run[name]
        assert np.abs(told[late:] - true[:-late])[200:].max() < 3e-3 * np.ptp(true)
        assert np.abs(told - true).max() > 5e-3 * np.ptp(true)


def read_late(bare, run):
    """By the firmware: exactly."""
    ratio = EVERYTHING.parameters["gear.ratio"]
    for name, true in (("position", run["motor_angle"] / ratio), ("current", run["motor_current"])):
        gap = np.abs(run[name][3:-1] - true[:-4])  # at the last sample there is no tick
        assert gap.max() < 1e-6 * np.ptp(true)


MARKS = {
    "leader_slack": ("dynamometer", {"length": 3e-3}, slack),
    "wire_compliance": ("dynamometer", {"leader": 5e-6}, stretched),
    "wire_compliance, follower": ("dynamometer", {"follower": 5e-6}, follower_stretched),
    "capstan": ("void", {"friction": 0.05}, rubbed),
    "gear_load": ("dynamometer", {"coefficient": 0.05}, loaded),
    "direction_friction": ("void", {"dry": 0.2}, one_way),
    "direction_friction, viscous": ("void", {"viscous": 0.4}, one_way_viscous),
    "stribeck": ("finely", {"torque": 2e-3}, held_back),
    "gear_backlash": ("void", {"gap": 0.02}, played),
    "torque_ripple": ("finely", {"amplitude": 1e-3}, rippled),
    "winding_heating": ("void", {"rise": 50.0}, heated),
    "supply_sag": ("dynamometer", {"resistance": 0.5}, sagged),
    "pwm_dead_band": ("void", {"width": 0.03}, swallowed),
    "spring_error": ("void", {"share": 0.2}, stronger),
    "spring_hysteresis": ("void", {"share": 0.2}, not_given_back),
    "hunt_crossley": ("soft ball", {"exponent": 0.3}, deeper),
    "hunt_crossley, dissipation": ("soft ball", {"dissipation": 3.0}, damped_with_depth),
    "viscoelastic_object": ("held ball", {"share": 0.5}, relaxed),
    "object_misplacement": ("dynamometer", {"x": 2e-3}, misplaced),
    "object_misplacement, y": ("dynamometer", {"y": 2e-3}, misplaced_upwards),
    "current_offset": ("void", {"offset": 0.05}, offset),
    "current_gain": ("void", {"error": 0.1}, scaled),
    "current_lag": ("finely", {"time": 2e-3}, smoothed),
    "force_lag": ("dynamometer", {"time": 0.05}, force_trails),
    "command_delay": ("dynamometer", {"time": 0.01}, all_late),
    "measurement_delay": ("finely", {"time": 4e-3}, told_late),
    "measurement_delay, sampled": ("sampled", {"time": 3e-3}, read_late),
}


def test_every_effect_leaves_its_mark():
    assert {name.partition(",")[0] for name in MARKS} == set(CATALOGUE)


@pytest.mark.parametrize("name", MARKS)
def test_mark(name):
    experiment, values, check = MARKS[name]
    effect = name.partition(",")[0]
    sizes = {f"{effect}__{each}": size for each, size in values.items()}
    check(ran(experiment), ran(experiment, **sizes))
