"""Experiments and short cuts that several physics tests share."""

import functools

import numpy as np

from hannes.control.firmware_memory import MEMORY
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter
from hannes.simulation.experiment.experiment import Experiment, Reference, Target
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.model import EQUATIONS
from hannes.simulation.simulate import simulate

GRASP = ((0.0, 0.0), (0.637, 9.84), (1.022, 0.0))
CLOSE = ((0.0, 0.0), (0.8, 14.0))  # winds more wire than the stops leave
FRICTIONLESS = {
    f"{place}.{name}_friction": 0.0
    for place in ("mcp", "pip", "cart")
    for name in ("breakaway", "coulomb", "viscous")
} | {"motor.dry_friction": 0.0, "motor.viscous_friction": 0.0}


def reference(points):
    """Reference through ((time [s], angle [rad]), ...)."""
    return Reference(np.array(points).T)


def grasp(shape="cylinder", duration=1.15, sampling=1000.0, controller="continuous", **values):
    """A grasp with the paper's reference; `values` of `object.*`, shape None for no object."""
    placed = {f"object.{name}": value for name, value in values.items()}
    target = Target(shape, placed) if shape else None
    return Experiment(
        f"{shape}", duration, reference(GRASP), target, sampling=sampling, controller=controller
    )


@functools.cache
def run(shape="cylinder", method="Rodas", rtol=1e-4, duration=1.15, **values):
    """A cached trajectory of `grasp`."""
    return simulate(Hand(), grasp(shape, duration, **values), method=method, rtol=rtol).require()


def worst(mine, theirs):
    """Largest difference of two traces as a share of the second's range."""
    return float(np.abs(mine - theirs).max() / np.ptp(theirs))


@kernel
def breaking(motor_speed, t, since, way, rattle):
    """A torque that from a time on is no number, infinite or explosive; before, it may rattle."""
    if t < since or way == 0.0:
        return rattle * np.sin(1e6 * t)
    if way == 1.0:
        return np.nan
    return np.inf if way == 2.0 else -1e300 * motor_speed


WAYS = {"not a number": 1.0, "infinite": 2.0, "overflowing": 3.0}
BREAK = Effect(
    "breaking",
    "The rates break.",
    "-",
    "a test",
    (
        Parameter("way", 0.0, "1", (0.0, 3.0), "how it breaks", off=0.0),
        Parameter("since", 0.05, "s", (0.0, 1.0), "when it breaks"),
        Parameter("rattle", 0.0, "N m", (0.0, 10.0), "far quicker than anything else", off=0.0),
    ),
    (Term(breaking, ("motor_torque",)),),
)


class Bench:
    """The hand's compiled rates outside of any experiment: free motion from any state."""

    def __init__(self, values, shape=None):
        hand = Hand().with_values(values)
        self.compiled = hand.compiled()
        self.p = hand.vector(shape)
        self.rest = hand.rest(self.compiled)
        self.memory = np.zeros(MEMORY)
        self.knots = np.array([[0.0, 1.0], [0.0, 0.0]])

    def place(self, name):
        """Slice of a state."""
        return self.compiled.states[name]

    def rates(self, time, state):
        """Rates of all states."""
        return self.compiled.fast.rates(time, state, self.p, self.knots, self.memory)

    def move(self, state, times):
        """States at `times` from `state` at times[0], shape (times, states)."""
        from scipy.integrate import solve_ivp

        found = solve_ivp(
            self.rates,
            (times[0], times[-1]),
            state,
            method="LSODA",
            t_eval=times,
            rtol=1e-10,
            atol=1e-12,
        )
        assert found.success
        return found.y.T


def channels():
    """Zeroed channels of the hand and their layout."""
    return np.zeros(EQUATIONS.channels.size), EQUATIONS.channels
