"""Who runs in the race and how: hannes at tolerances, MuJoCo at steps of its integrators."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.accuracy_work import alone
from benchmarks.mujoco import native, same
from benchmarks.mujoco.elements import Idiom
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Trajectory

TOLERANCES = (5e-2, 3e-2, 2e-2, 1e-2, 7e-3, 5e-3, 3e-3, 2e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
# Steps of MuJoCo between two samples, 1 ms apart.
SAME = {
    "Euler": (20, 30, 40, 60, 70, 80, 100, 120),
    "implicitfast": (60, 80, 120),
    "implicit": (60, 80, 120),
    "discrete": (60, 80, 120),
    "RK4": (30, 50, 80),
}
HELPED = {  # RK4 has no implicit part to help
    "Euler": (3, 5, 6, 8, 10, 20, 40, 80, 100),
    "implicitfast": (8, 80),
    "implicit": (8, 80),
    "discrete": (8, 80),
}
NATIVE = {
    "Euler": (2, 3, 4, 6, 8, 12),
    "implicitfast": (2, 3, 4, 6, 8, 12),
    "implicit": (2, 4, 8),
    "discrete": (1, 2, 4, 8, 16),
    "RK4": (8,),
}
FINEST = 200
Traces = Mapping[str, np.ndarray]
OURS, LOOP = "hannes through solve_ivp", "hannes"
CALLED, LINEARISED = "our equations in MuJoCo", "the same, linearised for it"
OWN = {  # by impedance of its contacts: the one nearest to our traces, and a cheaper one
    0.7: "MuJoCo's own elements, nearest",
    0.9: "MuJoCo's own elements, near its default",
}
IDIOMS = tuple(Idiom(impedance, limits) for impedance in OWN for limits in (False, True))


@dataclass(frozen=True, eq=False)
class Case:
    """A runner, how it integrates, its step or tolerance; `run` is timed, `traces` judged.

    `exact` is what this runner's traces tend to.
    """

    runner: str
    way: str
    step: str
    run: Callable[[], Any]
    traces: Callable[[], Traces | Trajectory]
    exact: Traces | Trajectory


def ours(hand: Hand, experiment: Experiment, exact: Trajectory) -> list[Case]:
    """hannes at several tolerances, as `simulate` calls it and by its compiled steps alone."""

    def case(rtol: float) -> tuple[Case, Case]:
        def run() -> Trajectory:
            return simulate(hand, experiment, rtol=rtol).require()

        step, steps = f"rtol {rtol:g}", alone(hand, experiment, rtol)
        return (
            Case(LOOP, "Rodas", step, steps, run, exact),
            Case(OURS, "Rodas", step, run, run, exact),
        )

    return [each for rtol in TOLERANCES for each in case(rtol)]


def called(hand: Hand, experiment: Experiment, exact: Trajectory, helped: bool) -> list[Case]:
    """Our equations in MuJoCo, linearised for it or not, by each of its integrators."""
    runner, ways = (LINEARISED, HELPED) if helped else (CALLED, SAME)

    def case(integrator: str, every: int) -> Case:
        run = same.launch(hand, experiment, integrator, every, helped)

        def traces() -> Trajectory:
            return replace(exact, states=same.states(run()))

        return Case(runner, integrator, _step(every), run, traces, exact)

    return [case(integrator, every) for integrator in ways for every in ways[integrator]]


def own(hand: Hand, experiment: Experiment, idiom: Idiom, limit: Traces) -> list[Case]:
    """MuJoCo's own elements, by each of its integrators."""

    def case(integrator: str, every: int) -> Case:
        run = native.launch(hand, experiment, idiom, integrator, every)

        def traces() -> Traces:
            return native.traces(run, hand)

        way = f"{integrator}, {idiom}"
        return Case(OWN[idiom.impedance], way, _step(every), run, traces, limit)

    return [case(integrator, every) for integrator in NATIVE for every in NATIVE[integrator]]


def own_limit(hand: Hand, experiment: Experiment, idiom: Idiom) -> Traces:
    """What MuJoCo's own elements tend to at fine steps."""
    run = native.launch(hand, experiment, idiom, "implicitfast", FINEST)
    return native.traces(run, hand)


def _step(every: int) -> str:
    return f"{1e3 / every:.3g} us"
