"""Grasps per second beside MuJoCo's rollout, both no worse than 1 % anywhere on the trace.

The dynamometer grasp, over and over on one thread, in turn. MuJoCo carries our equations in a
compiled callback, linearised for it, by the largest step of its Euler that is good enough; we take
the coarsest tolerance that is at least as good as that. Processor time, medians over repeats.
"""

import time
from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
from mujoco import rollout

from benchmarks.accuracy_work import TRACES, errors
from benchmarks.harness import Row, interval, must_show
from benchmarks.mujoco import same
from benchmarks.mujoco.cases import HELPED, TOLERANCES
from benchmarks.mujoco.engine import Launch, called_back
from hannes import Hand, load_experiment, simulate, simulate_many
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.trajectory import Trajectory

GOOD = 1.0  # %, worst error anywhere on current, force and leader tension


def worst(mine: Trajectory, exact: Trajectory) -> float:
    """Worst error of all traces [%]."""
    off = errors(mine, exact)
    return max(off[f"{name}_worst_%"] for name in TRACES)


def cheapest(hand: Hand, experiment: Experiment, exact: Trajectory) -> tuple[Launch, float]:
    """MuJoCo with the largest step that is good enough, and its error [%]."""
    for every in HELPED["Euler"]:
        run = same.launch(hand, experiment, "Euler", every, True)
        off = worst(replace(exact, states=same.states(run())), exact)
        if off <= GOOD:
            return run, off
    raise RuntimeError(f"no step of MuJoCo's is within {GOOD:g} % of the trace")


def rolled(run: Launch) -> Callable[[int], None]:
    """Roll out that many grasps in one call."""
    data, kind = mujoco.MjData(run.model), mujoco.mjtState.mjSTATE_FULLPHYSICS
    data.userdata[:] = run.userdata
    data.qpos[3 : 3 + run.angles.size] = run.angles
    start = np.zeros(mujoco.mj_stateSize(run.model, kind))
    mujoco.mj_getState(run.model, data, start, kind)

    def roll(count: int) -> None:
        with called_back(**run.callbacks):
            starts = np.tile(start, (count, 1))
            rollout.rollout(run.model, data, starts, nstep=(run.samples - 1) * run.every)

    return roll


def ours(hand: Hand, experiment: Experiment, rtol: float) -> Callable[[int], None]:
    """Simulate that many grasps in one call."""
    stiffness = hand.with_values(experiment.overrides()).parameters["object.stiffness"]

    def run(count: int) -> None:
        column = {"object.stiffness": np.full(count, stiffness)}
        how = {"channels": ("current", "force"), "workers": 1, "progress": False}
        for each in simulate_many(hand, experiment, column, rtol=rtol, **how):
            each.require()

    return run


def rate(run: Callable[[int], None], count: int) -> float:
    """Grasps per second of processor time."""
    start = time.process_time()
    run(count)
    return count / (time.process_time() - start)


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Both rates, and how many times MuJoCo's ours is."""
    hand, experiment = Hand(), load_experiment("dynamometer")[0].experiment
    exact = simulate(hand, experiment, method="Radau", rtol=1e-9).require()
    theirs, off = cheapest(hand, experiment, exact)
    for rtol in TOLERANCES:
        own = worst(simulate(hand, experiment, rtol=rtol).require(), exact)
        if own <= off:
            break
    else:
        raise RuntimeError(f"no tolerance of ours is as good as {off:g} %")
    roll, run = rolled(theirs), ours(hand, experiment, rtol)
    roll(1), run(10)
    rates = [(rate(run, 400), rate(roll, 10)) for _ in range(3 if quick else 9)]
    mine, other = np.array(rates).T
    step = f"{1e6 * theirs.model.opt.timestep:.3g} us"
    rows = [
        {"what": f"hannes, rtol {rtol:g}", "worst_%": own, "grasps_per_s": float(np.median(mine))},
        {"what": f"MuJoCo's rollout of our equations, Euler, {step}", "worst_%": off,
         "grasps_per_s": float(np.median(other))},
    ]  # fmt: skip
    times, ends = float(np.median(mine / other)), interval(mine / other)
    return rows, [must_show("grasps per second over MuJoCo's rollout", times, 1, times > 1) | ends]
