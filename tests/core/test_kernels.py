"""Compiled equals plain Python, kernel by kernel and assembled; what every effect promises."""

import functools
import importlib
import inspect
import math
import os
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from catalogued import EVERYTHING
from runs import BREAK, grasp

import hannes.contact
import hannes.control
import hannes.dynamics
from hannes.control.firmware_memory import MEMORY
from hannes.core.io.units import quantity
from hannes.core.kernels import smooth_switches
from hannes.core.kernels.jit import compiles, plain
from hannes.plants.axis import plant
from hannes.simulation.catalogue import effects
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.model import EQUATIONS
from hannes.simulation.simulate import simulate

POSITIVE = re.compile(
    "stiffness|damping|onset|width|limit|mass|length|inerti|induct|resist|gain|period|supply|radius"
    "|level|breakaway|coulomb|viscous|dry|friction_speed|half_|preload|coefficient|normal_force"
)


def discovered():
    """Every kernel under dynamics, contact, control and in onset, by module and name."""
    found, modules = {}, [smooth_switches]
    for package in (hannes.dynamics, hannes.contact, hannes.control):
        for each in pkgutil.iter_modules(package.__path__):
            modules.append(importlib.import_module(f"{package.__name__}.{each.name}"))
    for module in modules:
        for name, value in vars(module).items():
            if hasattr(value, "py_func") and value.__module__ == module.__name__:
                found[f"{module.__name__.removeprefix('hannes.')}.{name}"] = value
    return found


KERNELS = discovered() if compiles() else {}


WHOLE = {"driven"}  # kernels that take all phalanges at once
TUPLES = {  # arguments of several numbers: core and radius with the frame of a section; eq. 3
    "section": (0.02, 0.01, 0.005, 1.1, 0.2, -0.1, 0.9),
    "material": (8000.0, 60.0, 1e-4, 0.4, 5e-3),
}


def several(name, rng):
    """Values of a whole channel or table of parameters."""
    layouts = (EQUATIONS.parameters, EQUATIONS.channels)
    slot = next((each.slot(name) for each in layouts if name in each), None)
    return rng.uniform(-1.0, 1.0, slot.size) if slot and slot.axis else drawn(name, rng)


def drawn(name, rng, bounds=None):
    """A value for an argument of that name; its bounds where it is an effect's parameter."""
    if bounds:
        return rng.uniform(*bounds[name]) if name in bounds else drawn(name, rng)
    if name in TUPLES:
        return tuple(rng.uniform(0.8, 1.2) * value for value in TUPLES[name])
    if name == "knots":
        return np.array([np.sort(rng.uniform(-2, 2, 5)), rng.uniform(-2, 2, 5)])
    if name == "link":
        return int(rng.integers(2))
    if name == "bits":
        return float(rng.integers(6, 16))
    return rng.uniform(0.01, 2.0) if POSITIVE.search(name) else rng.uniform(-2.0, 2.0)


def arguments(kernel, rng, bounds=None):
    draw = several if plain(kernel).__name__ in WHOLE else functools.partial(drawn, bounds=bounds)
    return [draw(name, rng) for name in inspect.signature(plain(kernel)).parameters]


def test_kernels_are_found(compiling):
    assert len(KERNELS) >= 30
    assert {
        "core.kernels.smooth_switches.limited",
        "dynamics.friction.stribeck",
        "contact.penalty.sensed",
    } <= set(KERNELS)


@pytest.mark.parametrize("name", KERNELS)
def test_compiled_equals_plain(name):
    kernel, rng = KERNELS[name], np.random.default_rng(6)
    for _ in range(200):
        given = arguments(kernel, rng)
        mine, expected = np.ravel(kernel(*given)), np.ravel(plain(kernel)(*given))
        assert mine.size == expected.size
        assert np.isfinite(expected).all()
        np.testing.assert_allclose(mine, expected, rtol=1e-11, atol=1e-13)


# --- the assembled model ----------------------------------------------------------------------

PLAIN = """
import sys
import numpy as np
from catalogued import EVERYTHING
from hannes.core.kernels.jit import compiles

assert not compiles()
given = np.load(sys.argv[1])
model = EVERYTHING.compiled(EVERYTHING.effects)
p, knots, memory = given["p"], given["knots"], given["memory"]
rates = [model.fast.rates(t, y, p, knots, memory) for t, y in zip(given["t"], given["y"])]
outputs = model.observed.observe(given["t"], given["y"], p, knots, given["memories"])
sampled = p.copy()
sampled[model.parameters["controller_sampled"]] = 1.0
held = [model.fast.rates(t, y, sampled, knots, memory) for t, y in zip(given["t"], given["y"])]
ticks = []
for t, y in zip(given["t"], given["y"]):
    after = memory.copy()
    model.fast.tick(t, y, sampled, knots, after)
    ticks.append(after)
np.savez(sys.argv[2], rates=rates, outputs=outputs, held=held, ticks=ticks)
"""


def everything_on():
    """The hand with all effects it can carry, each a twentieth of its range away from off."""
    sizes = {
        each.full_name(a.name): a.off + 0.05 * (a.bounds[1] - a.off)
        for each in EVERYTHING.effects
        if each is not BREAK
        for a in each.amplitudes
    }
    return EVERYTHING.with_values(sizes), EVERYTHING.effects


@pytest.fixture(scope="module")
def both(tmp_path_factory, compiling):
    """Results of the compiled model here and of plain Python in a process of its own."""
    folder = tmp_path_factory.mktemp("plain")
    hand, chosen = everything_on()
    experiment = grasp(duration=0.7, sampling=50.0)
    run = simulate(hand, experiment, effects=chosen).require()
    rng = np.random.default_rng(7)
    states = run.states[5:] * rng.uniform(0.99, 1.01, run.states[5:].shape)
    given = {
        "t": run.time[5:],
        "y": states,
        "p": run.parameters,
        "knots": run.knots,
        "memory": rng.uniform(-0.5, 0.5, MEMORY),
        "memories": np.zeros((states.shape[0], MEMORY)),
    }
    np.savez(folder / "given.npz", **given)
    done = subprocess.run(
        [sys.executable, "-c", PLAIN, folder / "given.npz", folder / "found.npz"],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return run.compiled, given, np.load(folder / "found.npz")


def close(mine, expected):
    """Equal to 1e-12 of each column's size over all states."""
    size = np.abs(expected).max(axis=0)
    return (np.abs(mine - expected) <= 1e-12 * np.where(size > 0.0, size, 1.0)).all()


@pytest.mark.slow
@pytest.mark.parametrize("sampled", [False, True])
def test_compiled_rates_equal_plain_python(both, sampled):
    model, given, found = both
    p = given["p"].copy()
    p[model.parameters["controller_sampled"]] = float(sampled)
    rates = [
        model.fast.rates(t, y, p, given["knots"], given["memory"])
        for t, y in zip(given["t"], given["y"], strict=True)
    ]
    assert np.isfinite(rates).all()
    assert close(np.array(rates), found["held" if sampled else "rates"])


def test_compiled_outputs_equal_plain_python(both):
    model, given, found = both
    names = ("t", "y", "p", "knots", "memories")
    outputs = model.observed.observe(*(given[name] for name in names))
    assert outputs[:, model.outputs["force"]].max() > 1.0
    assert close(outputs, found["outputs"])


def test_compiled_ticks_equal_plain_python(both):
    model, given, found = both
    p, ticks = given["p"].copy(), []
    p[model.parameters["controller_sampled"]] = 1.0
    for t, y in zip(given["t"], given["y"], strict=True):
        ticks.append(given["memory"].copy())
        model.fast.tick(t, y, p, given["knots"], ticks[-1])
    assert close(np.array(ticks), found["ticks"])


# --- the catalogue ----------------------------------------------------------------------------

CATALOGUE = pytest.mark.parametrize("effect", effects().values(), ids=effects())


@CATALOGUE
def test_effect_explains_itself(effect):
    assert re.fullmatch(r"[a-z][a-z0-9_]*", effect.name)
    assert effect.meaning[0].isupper() and effect.meaning.endswith(".")
    assert len(effect.meaning.split()) >= 5
    assert effect.equation.strip() and effect.source.strip()
    for each in (*effect.parameters, *effect.states):
        assert each.doc.strip()
        assert quantity(f"2 {each.unit}", each.unit, each.name) == pytest.approx(2.0)
    shown = str(effect)
    for text in (effect.name, effect.meaning, effect.equation, effect.source):
        assert text in shown
    for each in effect.parameters:
        assert effect.full_name(each.name) in shown


@CATALOGUE
def test_effect_lives_in_its_own_file(effect):
    files = {Path(inspect.getfile(plain(term.kernel))).stem for term in effect.terms}
    assert files == {effect.name}


@CATALOGUE
def test_effect_ships_at_off_within_its_bounds(effect):
    for each in effect.amplitudes:
        low, high = each.bounds
        assert low <= each.off <= high and each.value == each.off
        assert math.isfinite(low) and math.isfinite(high)
    names = {effect.full_name(each.name) for each in effect.parameters}
    assert not names & set(Hand().parameters)


@CATALOGUE
def test_effect_fits_a_plant(effect):
    assert EQUATIONS.accepts(effect) == "" or plant.EQUATIONS.accepts(effect) == ""


@CATALOGUE
@pytest.mark.parametrize("at_off", [True, False])
def test_effect_is_finite_and_vanishes_at_off(effect, at_off):
    rng = np.random.default_rng(8)
    bounds = {each.name: each.bounds for each in effect.parameters}
    if at_off:
        bounds |= {each.name: (each.off, each.off) for each in effect.amplitudes}
    for _ in range(100):
        for term in effect.terms:
            found = np.ravel(plain(term.kernel)(*arguments(term.kernel, rng, bounds)))
            assert found.size == len(term.writes) + len(term.states)
            assert np.isfinite(found).all()
            if at_off:
                assert (found[: len(term.writes)] == 0.0).all()
