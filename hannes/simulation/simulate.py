"""Run an experiment: scipy's solve_ivp by the method of rodas, or by one of its own."""

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import BadInput, nearest
from hannes.simulation.compiled_call import Plan, ended, say_when_compiling
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.integrate import METHODS, Initial
from hannes.simulation.trajectory import Trajectory


def simulate(
    hand: Hand,
    experiment: Experiment,
    *,
    method: str = "Rodas",
    rtol: float = 1e-4,
    effects: tuple[Effect, ...] | None = None,
) -> Trajectory:
    """Simulate `experiment` with `hand` and return its Trajectory, completed or not.

    `method` is "Rodas" (simulation/rodas) or one of scipy's; `rtol` the relative tolerance,
    absolute ones follow from each state's declared tolerance. `effects` fixes the set that is
    compiled in (default: those of `hand` that are not off). Raises BadInput for a bad method,
    tolerance or value.
    """
    if method not in METHODS:
        raise BadInput(f'unknown method "{method}"{nearest(method, METHODS)}')
    check_tolerance(rtol)
    posed = hand.with_values(experiment.overrides())
    compiled = posed.compiled(effects)
    p, rest = posed.vector(experiment.shape, effects), posed.rest(compiled)
    if method == "Rodas" and experiment.controller == "sampled":
        return _firmware(Plan.of(compiled, experiment, rtol), experiment, p, rest)
    say_when_compiling(compiled, "steps_on" if method == "Rodas" else "rates")
    return Initial(compiled, p, rest, experiment, method, rtol).run()


def _firmware(plan: Plan, experiment: Experiment, p: np.ndarray, rest: np.ndarray) -> Trajectory:
    """Tick after tick in one compiled call: scipy would be set up anew for every millisecond."""
    ran = plan.make_ready().run(p[np.newaxis], rest[np.newaxis])
    counts, reached = ran.counts[0], ran.counts[0, 5]
    return Trajectory(
        experiment,
        plan.times[:reached],
        ran.rows[:reached],
        *ended(counts),
        plan.cost(counts, p, ran.seconds),
        plan.compiled,
        p,
        plan.knots,
        ran.memories[:reached],
    )


def check_tolerance(rtol: float) -> None:
    """Raise BadInput where `rtol` cannot be met."""
    if not 1e-13 < rtol < 1.0:
        raise BadInput(f"rtol = {rtol:g}: expected a value between 1e-13 and 1")
