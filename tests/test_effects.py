"""The catalogue: what each effect promises, and the mark that it leaves in a run.

All runs are by one model with the whole catalogue in it, every amplitude but those told at off.
"""

import functools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from runs import grasp, reference

from benchmarks.truth import effects as second
from hannes._jit import plain
from hannes.catalogue import effects
from hannes.experiment import Experiment, Target
from hannes.hand import Hand
from hannes.ledger import energy_ledger
from hannes.simulate import simulate
from hannes.spec import load

CATALOGUE = effects()
EVERYTHING = Hand(tuple(CATALOGUE))
AMPLITUDES = {
    effect.full_name(each.name): each for effect in CATALOGUE.values() for each in effect.amplitudes
}
SHIPPED = ("dynamometer", "void-closure", "soft-ball")
BALL = {"stiffness": 800.0, "damping": 20.0, "radius": 0.036, "x": 4e-3, "y": -47e-3}
EXPERIMENTS = {
    "void": grasp(None),
    "dynamometer": grasp(),
    "soft ball": grasp("sphere", **BALL),
    "held ball": replace(
        grasp("sphere", 1.5, **BALL), reference=reference(((0.0, 0.0), (0.637, 9.84)))
    ),
    "finely": grasp(None, 0.3, sampling=20_000.0),
    "sampled": grasp(controller="sampled"),
}


def _table():
    """Rows of the second implementation's table: name -> (asterisk, unit, low, high, default)."""
    row = r"^(\w+\.\w+) (\*)? *(\S+(?: \S+)?)  +(\S+) \.\. (\S+)(?:.*\n +)?(?: ?\((\S+)\))?"
    found = {}
    for name, star, unit, low, high, default in re.findall(row, second.__doc__ or "", re.M):
        found[name] = (star, unit, float(low), float(high), float(default) if star else None)
    return found


TABLE = {name: row for name, row in _table().items() if name.partition(".")[0] in CATALOGUE}


@functools.cache
def ran(experiment, **values):
    """A cached run; values by full name with __ for the dot."""
    hand = EVERYTHING.with_values({n.replace("__", "."): x for n, x in values.items()})
    found = simulate(hand, EXPERIMENTS[experiment], rtol=1e-6, effects=EVERYTHING.effects)
    return found.require()


def mean(run, name, start, end):
    """Mean of a channel over part of a run."""
    inside = (run.time >= start) & (run.time < end)
    return float(run[name][inside].mean())


# --- what is declared -------------------------------------------------------------------------


def test_the_catalogue_is_the_agreed_one():
    whole = {each.__name__.rpartition(".")[2] for each in second.CATALOGUE}
    assert set(CATALOGUE) == whole and len(CATALOGUE) == 22


@pytest.mark.parametrize("name", TABLE)
def test_parameters_are_the_agreed_ones(name):
    star, unit, low, high, default = TABLE[name]
    effect, _, own = name.partition(".")
    each = next(p for p in CATALOGUE[effect].parameters if p.name == own)
    assert each.unit == unit
    assert each.bounds[0] <= low and high <= each.bounds[1]
    assert (each.off is None) == (star == "*")
    assert each.value == (default if star else 0.0)


def test_no_parameter_is_left_out_of_the_table():
    declared = {e.full_name(p.name) for e in CATALOGUE.values() for p in e.parameters}
    assert declared == set(TABLE)


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=CATALOGUE)
def test_texts_fit_a_terminal(effect):
    assert max(map(len, str(effect).splitlines())) <= 78
    assert re.search(r"\(1[4-9]\d\d\)|\(20\d\d\)|paper", effect.source)


# --- off ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CATALOGUE)
def test_at_off_an_effect_is_left_out(name):
    dressed = Hand([name])
    assert dressed.compiled() is Hand().compiled()
    assert dressed.vector("cylinder").tobytes() == Hand().vector("cylinder").tobytes()


def test_at_off_the_whole_catalogue_changes_nothing_even_where_it_is_compiled_in():
    bare = simulate(Hand(), grasp(), rtol=1e-7).require()
    dressed = simulate(EVERYTHING, grasp(), rtol=1e-7, effects=EVERYTHING.effects).require()
    for name in ("current", "force", "sensor", "position", "leader_tension", "duty", "supply"):
        assert np.abs(bare[name] - dressed[name]).max() <= 2e-5 * max(np.ptp(bare[name]), 1e-9)


GRAIN = 3e-6  # of a peak; so much runs differ by their steps


@pytest.mark.parametrize("name", AMPLITUDES)
def test_a_small_amplitude_does_little(name):
    """A thirtieth of the size leaves at most a sixth of the mark."""
    size = max(TABLE[name][2], TABLE[name][3] / 100.0)
    # backlash is a free run of the motor at the start, in no channel to be seen later
    bare, large, small = (
        ran("dynamometer", **{name.replace(".", "__"): share * size})
        for share in (0.0, 1.0, 1 / 30)
    )
    for channel in ("current", "force", "position", "duty", "motor_current"):
        peak = np.abs(bare[channel]).max()
        whole, part = (np.abs(run[channel] - bare[channel]).mean() for run in (large, small))
        assert part <= whole / 6.0 + GRAIN * peak, channel


# --- kernels against their equations ----------------------------------------------------------


def sign(x):
    return np.tanh(x)


def friction_of_capstan(leader_tension, rate_a, rate_b, rate_thumb, friction):
    speeds = np.cumsum([rate_thumb + rate_b, rate_b, rate_a])[::-1]
    tensions = leader_tension * np.exp(-friction * np.pi * np.cumsum(sign(speeds / 5e-3)))
    spans = np.array([leader_tension, *tensions])
    return *(0.5 * (spans[[0, 2]] + spans[[1, 3]]) - leader_tension), spans[3] - leader_tension


def ratio_of_ends(follower_slip, friction):
    ends = np.exp(-friction * np.pi * sign(follower_slip / 5e-3))  # first finger's to second's
    return (1.0 - ends) / (1.0 + ends)


def peak(motor_speed, torque, speed):
    u = motor_speed / (math.sqrt(2.0) * speed)
    return math.sqrt(2.0 * math.e) * torque * u * math.exp(-(u**2))


def way(motor_speed, motor_friction_speed):
    return sign(motor_speed / motor_friction_speed)


def spring(angle, rest, stiffness, preload):
    return preload + stiffness * (angle - rest)


def deep(x, rate, k, exponent, dissipation):
    if x <= 0.0:
        return 0.0
    return k * x * (x / 1e-3) ** exponent * (1.0 + dissipation * rate) - k * x


def crept(x, k, state, share, time):
    d = share * state
    return -k * d, (share * max(0.0, x - d) - d) / time / share


def lag(now, state, time):
    return state - now, (now - state) / time


def clip(x, limit):
    """A corner that is round over 2 % at either side is left out of the comparison."""
    return min(max(x, -limit), limit)


LAWS = {
    "leader_slack.free_length": lambda length: length,
    "wire_compliance.softer_leader": lambda leader: leader,
    "wire_compliance.softer_follower": lambda follower: follower,
    "capstan.along_leader": friction_of_capstan,
    "capstan.over_cart": ratio_of_ends,
    "gear_load.load_loss": lambda w, ws, load, mu: mu * abs(load) * way(w, ws),
    "direction_friction.asymmetry": lambda w, dry, ws, viscous, a, b: (
        a * dry * abs(way(w, ws)) + b * viscous * abs(w)
    ),
    "stribeck.breakaway": peak,
    "gear_backlash.lost_turn": lambda th, ratio, gap: -clip(th / ratio, gap / 2),
    "gear_backlash.lost_wire": lambda th, ratio, r, gap: r * clip(th / ratio, gap / 2),
    "torque_ripple.ripple": lambda th, a, n, phase: a * math.sin(n * th + phase),
    "winding_heating.warm": lambda r, k, rise: (r * 3.93e-3 * rise, -k * 1.1e-3 * rise),
    "supply_sag.sag": lambda duty, current, r: -r * duty * current,
    "pwm_dead_band.swallowed": lambda duty, width: -clip(duty, width),
    "spring_error.stronger": lambda q, rest, k, pre, share: share * spring(q, rest, k, pre),
    "spring_hysteresis.rubbing": lambda q, w, rest, k, pre, z, share, width: (
        share * spring(q, rest, k, pre) * z,
        (w - abs(w) * z) / width,
    ),
    "hunt_crossley.deepening": deep,
    "viscoelastic_object.creeping": crept,
    "object_misplacement.moved": lambda x, y: (x, y),
    "current_offset.shifted": lambda offset: offset,
    "current_gain.exaggerated": lambda current, error: error * current,
    "current_lag.trailing": lag,
    "force_lag.grip": lag,
    "force_lag.face": lag,
    "command_delay.late": lambda time: -time,
    "measurement_delay.late_position": lambda x, held, sampled, p, q, time: (
        (held - x, 0.0, 0.0) if sampled > 0.5 else (-q, q / time, (12.0 * (x - p) - 6.0 * q) / time)
    ),
    "measurement_delay.late_current": lambda x, held, sampled, p, q, time: (
        (held - x, 0.0, 0.0) if sampled > 0.5 else (-q, q / time, (12.0 * (x - p) - 6.0 * q) / time)
    ),
    "measurement_delay.age": lambda time: time,
}
SIZES = {  # of arguments, where they are not of the order of 1
    "penetration": 5e-3,
    "penetration_rate": 0.2,
    "crept": 1e-3,
    "follower_slip": 1e-2,
    "rate_a": 1e-2,
    "rate_b": 1e-2,
    "rate_thumb": 1e-2,
    "motor_speed": 30.0,
    "motor_friction_speed": 5.0,
    "object_stiffness": 1e4,
}


def test_every_kernel_has_its_law_here():
    names = {f"{e.name}.{plain(t.kernel).__name__}" for e in CATALOGUE.values() for t in e.terms}
    assert names == set(LAWS)


@pytest.mark.parametrize("law", LAWS)
def test_kernel_is_its_equation(law):
    effect = CATALOGUE[law.partition(".")[0]]
    (term,) = (t for t in effect.terms if law.endswith("." + plain(t.kernel).__name__))
    bounds, rng = {each.name: each.bounds for each in effect.parameters}, np.random.default_rng(5)
    for _ in range(300):
        given = [
            rng.uniform(*bounds[name]) if name in bounds else rng.normal() * SIZES.get(name, 1.0)
            for name in term.arguments
        ]
        mine, expected = np.ravel(term.kernel(*given)), np.ravel(LAWS[law](*given))
        rounded = 0.02 * np.abs(expected) if "backlash" in law else 0.0
        size = np.abs(expected) + 1e-12
        assert (np.abs(mine - expected) <= 1e-9 * size + rounded).all(), given


# --- marks in the trace -------------------------------------------------------------------------
#
# Each takes the run without and the run with the effect.


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


# --- energy -------------------------------------------------------------------------------------

# Entry of the ledger that an effect makes larger.
LOSSES = {
    "capstan.friction": "wire_friction",
    "gear_load.coefficient": "gear_friction",
    "winding_heating.rise": "copper",
    "spring_hysteresis.share": "spring",
    "viscoelastic_object.share": "contact_normal",
    "hunt_crossley.dissipation": "contact_normal",
}


@functools.cache
def ledger(name, size):
    hand = EVERYTHING.with_values({name: size} if name else {})
    run = simulate(hand, grasp(sampling=20_000.0), rtol=1e-6, effects=EVERYTHING.effects)
    return energy_ledger(run.require())


@pytest.mark.parametrize("name", AMPLITUDES)
def test_ledger_closes(name):
    found, bare = ledger(name, 0.5 * TABLE[name][3]), ledger("", 0.0)
    assert abs(found["residual"]) < 1e-4
    assert found["wire_friction"] >= 0.0 == bare["wire_friction"]
    if name in LOSSES:
        assert found[LOSSES[name]] > bare[LOSSES[name]] + 1e-4 * bare["electrical"]
    if name == "torque_ripple.amplitude":  # gives back what it takes
        assert 0.0 != abs(found["motor_torque"]) < 1e-3 * found["electrical"]


# --- sizes and cost ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", AMPLITUDES)
def test_shipped_experiments_run_at_the_ends_of_the_range(name):
    each = AMPLITUDES[name]
    for size in {TABLE[name][2], TABLE[name][3], *each.bounds} - {each.off}:
        hand = EVERYTHING.with_values({name: size})
        for shipped in SHIPPED:
            (variant,) = load(shipped)
            run = simulate(hand, variant.experiment, effects=EVERYTHING.effects).require()
            assert np.isfinite(run["current"]).all() and np.isfinite(run["force"]).all()


def whole_catalogue(share):
    """Every effect at a share of the largest size it may physically have."""
    return EVERYTHING.with_values({name: share * TABLE[name][3] for name in AMPLITUDES})


@pytest.mark.parametrize("shipped", SHIPPED)
def test_the_whole_catalogue_keeps_the_structure_and_the_steps(shipped):
    (variant,) = load(shipped)
    bare = simulate(Hand(), variant.experiment).require()
    run = simulate(whole_catalogue(1e-3), variant.experiment).require()
    assert run.compiled.jacobian_kind == "structured"
    assert run.cost.evaluations < 1.5 * bare.cost.evaluations


def test_the_whole_catalogue_moves_the_same_by_another_method():
    experiment = Experiment("all", 0.5, grasp().reference, Target("cylinder"))
    mine, theirs = (
        simulate(whole_catalogue(0.1), experiment, method=method, rtol=1e-6).require()
        for method in ("Rodas", "Radau")
    )
    for name in ("current", "force", "position"):
        assert np.abs(mine[name] - theirs[name]).max() < 1e-3 * np.ptp(theirs[name])


def test_delayed_readings_are_the_same_by_another_method():
    hand = EVERYTHING.with_values({"measurement_delay.time": 2.3e-3})
    short = replace(EXPERIMENTS["sampled"], duration=0.1)
    mine, theirs = (
        simulate(hand, short, method=method, rtol=1e-6, effects=EVERYTHING.effects).require()
        for method in ("Rodas", "LSODA")
    )
    for name in ("current", "position", "duty"):
        assert np.abs(mine[name] - theirs[name]).max() < 1e-3 * np.ptp(theirs[name])
