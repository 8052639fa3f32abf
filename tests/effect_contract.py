"""What the tests of every effect share: formulas against kernels, a run without and with it.

Each effect of the package has a file tests/effects/test_NAME.py: its equation written a second
time, and the signature that it leaves in a run.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from catalogued import CATALOGUE, EVERYTHING, ledger, ran

from hannes.core.kernels.jit import plain

DRAWS = 300
# Of arguments that are not of the order of 1.
SIZES = {
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


def sign(x):
    """The smooth sign that friction has."""
    return np.tanh(x)


def lag(now, state, time):
    """What a first-order lag adds to a reading, and its state's rate."""
    return state - now, (now - state) / time


def check_equations(
    name: str,
    formulas: Mapping[str, Callable[..., Any]],
    sizes: Mapping[str, float] = SIZES,
    rounded: float = 0.0,
) -> None:
    """Compare each kernel of an effect with its formula at random arguments.

    A formula takes the kernel's arguments and returns what the kernel does. `sizes` are those of
    arguments that are not of the order of 1; `rounded`: share by which a rounded corner is off.
    """
    effect, rng = CATALOGUE[name], np.random.default_rng(5)
    bounds = {each.name: each.bounds for each in effect.parameters}
    kernels = {plain(term.kernel).__name__: term for term in effect.terms}
    assert kernels.keys() == formulas.keys(), f"{name}: a formula for each kernel"
    for kernel, term in kernels.items():
        for _ in range(DRAWS):
            given = [
                rng.uniform(*bounds[each])
                if each in bounds
                else rng.normal() * sizes.get(each, 1.0)
                for each in term.arguments
            ]
            mine, expected = np.ravel(term.kernel(*given)), np.ravel(formulas[kernel](*given))
            size = np.abs(expected) + 1e-12
            assert (np.abs(mine - expected) <= (1e-9 + rounded) * size).all(), (kernel, given)


def runs(name: str, experiment: str, **values: float) -> tuple[Any, Any]:
    """A run of the hand without the effect, and one with its parameters at `values`."""
    return ran(experiment), ran(experiment, **{f"{name}__{key}": x for key, x in values.items()})


def check_loss(amplitude: str, entry: str) -> None:
    """At half its largest physical size an effect adds to an entry of the energy ledger."""
    found, bare = ledger(amplitude), ledger()
    assert found[entry] > bare[entry] + 1e-4 * bare["electrical"]


def parameter(name: str) -> float:
    """One of the hand's parameters, as shipped."""
    return EVERYTHING.parameters[name]


def mean(run, name, start, end):
    """Mean of a channel over part of a run."""
    inside = (run.time >= start) & (run.time < end)
    return float(run[name][inside].mean())


def touch(run):
    """When the hand first presses on the object [s]."""
    return run.time[np.argmax(run["force"] > 1.0)]


def torque(run, start, end):
    """Mean torque of the motor over part of a run [N m]."""
    return parameter("motor.torque_constant") * mean(run, "current", start, end)
